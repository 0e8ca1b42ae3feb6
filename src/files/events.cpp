#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "files/photographs.h"
#include "files/points.h"
#include "io/csv.h"
#include "io/json.h"
#include "piste/io/solution_io.h"
#include "points/mark_delay.h"

namespace piste {
namespace {

// Instants without a delay: t − offset − drift · (t − first t).
std::vector<Mark> marks_of(const EventSource& source, std::optional<int> week, double near) {
  std::vector<Mark> marks = read_marks(source.marks, week, near);
  const double first = std::ranges::min(marks, {}, &Mark::time).time;
  for (Mark& mark : marks) mark.time -= source.offset + source.drift * (mark.time - first);
  return marks;
}

std::string found_text(const std::string& file, const MarkDelay& found, std::size_t marks) {
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  return json::object(
      {{"file", json::string(file)},
       {"delay_s", number(found.delay)},
       {"sigma_delay_s", number(found.sigma)},
       {"offset_m", fmt::format("[{:.6g}, {:.6g}, {:.6g}]", found.offset.x(), found.offset.y(), found.offset.z())},
       {"residual_m", number(found.residual)},
       {"marks", fmt::format("{}", marks)},
       {"used", fmt::format("{}", found.used)}});
}

void write_if_any(OutputFolder& output, const std::string& name, bool any, const std::string& text) {
  if (any) {
    output.write(name, text);
  } else {
    output.withdraw(name);
  }
}

}  // namespace

void write_events(OutputFolder& output, const Replay& run, const ReplayConfig& config, std::optional<int> week) {
  std::string rows;
  std::vector<std::string> found;
  std::vector<PlacedMark> metashape, pix4d;
  std::vector<std::string> names;
  PlaceCsv csv({}, run.log.world, [&](std::string_view piece) { rows += piece; });
  for (const EventSource& source : config.events) {
    const OutputPoint* named = config.output.point(source.at);
    const OutputPoint point = named != nullptr ? *named : OutputPoint{};
    const std::vector<Mark> marks = marks_of(source, week, run.log.imu.front().time);
    double delay = source.delay;
    if (source.find_delay) {
      const MarkDelay estimated = find_mark_delay(run, marks, point, source.marks.file);
      found.push_back(found_text(source.marks.file, estimated, marks.size()));
      delay = estimated.delay;
    }
    std::vector<double> times;
    times.reserve(marks.size());
    for (const Mark& mark : marks) times.push_back(mark.time + delay);
    const std::vector<PlacedState> states = states_at(run, times, source.marks.file);
    for (std::size_t i = 0; i < marks.size(); ++i) {
      const PlacedPoint placed = place(run.log.world, states[i], point);
      csv.add(placed.time, placed.navigation, sigmas_of(placed));
      names.push_back(csv_cell(marks[i].name));
      if (source.metashape) metashape.push_back({marks[i].name, placed});
      if (source.pix4d) pix4d.push_back({marks[i].name, placed});
    }
  }
  csv.finish();
  std::string text;
  std::size_t at = 0;
  const auto take_row = [&](std::string_view name) {
    const std::size_t end = rows.find('\n', at) + 1;
    fmt::format_to(std::back_inserter(text), "{},{}", name, std::string_view(rows).substr(at, end - at));
    at = end;
  };
  take_row("name");
  for (const std::string& name : names) take_row(name);
  write_if_any(output, "events.csv", !config.events.empty(), text);
  write_if_any(output, "events.json", !found.empty(), json::array(found) + "\n");
  write_if_any(output, "events_metashape.txt", !metashape.empty(), metashape_text(metashape));
  write_if_any(output, "events_pix4d.txt", !pix4d.empty(), pix4d_text(pix4d));
}

}  // namespace piste
