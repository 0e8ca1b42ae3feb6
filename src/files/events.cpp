#include <fmt/format.h>

#include "files/points.h"
#include "piste/core/error.h"
#include "piste/io/solution_io.h"

namespace piste {
namespace {

struct Event {
  std::string name;
  double time;
};

// Instant = t − offset − drift · (t − first t) + delay.
std::vector<Event> events_of(const EventSource& source, std::optional<int> week, double near) {
  const std::vector<Mark> marks = read_marks(source.marks, week, near);
  double first = marks.front().time;
  for (const Mark& mark : marks) first = std::min(first, mark.time);
  std::vector<Event> events;
  events.reserve(marks.size());
  for (const Mark& mark : marks) {
    events.push_back({mark.name, mark.time - source.offset - source.drift * (mark.time - first) + source.delay});
  }
  return events;
}

// A name as a cell: in quotes where it has a comma or a quote.
std::string cell(const std::string& name) {
  if (name.find_first_of(",\"\n") == std::string::npos) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

void write_events(OutputFolder& output, const Replay& run, const ReplayConfig& config, std::optional<int> week) {
  if (config.events.empty()) return output.withdraw("events.csv");
  std::string text;
  for (const EventSource& source : config.events) {
    const OutputPoint* point = config.output.point(source.at);
    const std::vector<Event> events = events_of(source, week, run.log.imu.front().time);
    std::vector<double> times;
    times.reserve(events.size());
    for (const Event& event : events) times.push_back(event.time);
    const std::vector<PlacedState> states = states_at(run, times, source.marks.file);
    std::string rows;
    PlaceCsv csv({}, run.log.world, [&](std::string_view piece) { rows += piece; });
    for (const PlacedState& state : states) {
      const PlacedPoint placed = place(run.log.world, state, point != nullptr ? *point : OutputPoint{});
      csv.add(placed.time, placed.navigation, sigmas_of(placed));
    }
    csv.finish();
    const std::size_t head = rows.find('\n') + 1;
    if (text.empty()) text = "name," + rows.substr(0, head);
    std::size_t at = head;
    for (const Event& event : events) {
      const std::size_t end = rows.find('\n', at) + 1;
      text += cell(event.name) + "," + rows.substr(at, end - at);
      at = end;
    }
  }
  output.write("events.csv", text);
}

}  // namespace piste
