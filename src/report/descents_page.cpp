#include "piste/report/descents_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plot/markup.h"
#include "plot/svg.h"
#include "report/drawing.h"
#include "report/page.h"

namespace piste {
namespace {

constexpr double kShownLeast = 0.5e-4;  // s: what rounds to more than nothing

// `+0.1234 ± 0.0004`, without a sigma where it is not known.
std::string gained_text(double gained, double sigma) {
  if (std::abs(gained) < kShownLeast) gained = 0;
  return std::isfinite(sigma) ? fmt::format("{:+.4f} ± {:.4f}", gained, sigma) : fmt::format("{:+.4f}", gained);
}

// Where a run lost and gained most, in one sentence.
std::string most_text(const DescentReport& report, std::size_t r) {
  const auto by = [r](const Section& a, const Section& b) { return a.gained[r] < b.gained[r]; };
  const Section &worst = *std::min_element(report.sections.begin(), report.sections.end(), by),
                &best = *std::max_element(report.sections.begin(), report.sections.end(), by);
  const Crossing& end = report.gates.back().runs[r];
  std::string text = std::abs(end.gained) < kShownLeast
                         ? fmt::format("{} took as long as {} in all", report.runs[r], report.runs[0])
                         : fmt::format("{} {} {} s on {} in all", report.runs[r], end.gained < 0 ? "lost" : "gained",
                                       gained_text(std::abs(end.gained), end.sigma_gained).substr(1), report.runs[0]);
  if (worst.gained[r] < -kShownLeast) {
    text += fmt::format("; most was lost from {} to {}: {} s", worst.from, worst.to,
                        gained_text(-worst.gained[r], worst.sigma[r]).substr(1));
  }
  if (best.gained[r] > kShownLeast) {
    text += fmt::format("; most was gained from {} to {}: {} s", best.from, best.to,
                        gained_text(best.gained[r], best.sigma[r]).substr(1));
  }
  return text + ".";
}

std::string section_table(const DescentReport& report) {
  page::Row head{"section", "length [m]"};
  for (const std::string& name : report.runs) head.push_back(name + " [s]");
  for (std::size_t r = 1; r < report.runs.size(); ++r) head.push_back(report.runs[r] + " gained [s]");
  std::vector<page::Row> rows;
  for (const Section& s : report.sections) {
    page::Row row{fmt::format("{} – {}", s.from, s.to), fmt::format("{:.1f}", s.length)};
    for (const double duration : s.duration) row.push_back(fmt::format("{:.3f}", duration));
    for (std::size_t r = 1; r < report.runs.size(); ++r) row.push_back(gained_text(s.gained[r], s.sigma[r]));
    rows.push_back(std::move(row));
  }
  return page::wide(page::table("Gained is positive where the run took less time than the first", head, rows));
}

Figure over_distance(const DescentReport& report, const char* name, const char* title, const char* unit,
                     double Crossing::*of, double Crossing::*sigma, std::size_t first) {
  Plot plot(title, {"distance along the line [m]"}, {unit}, fmt::format("{} over the distance along the line", title));
  constexpr int kHeight = 330;
  plot.size(Plot::kPageWidth, kHeight);
  std::vector<double> distance;
  for (const Passage& place : report.along) distance.push_back(place.distance);
  for (std::size_t r = first; r < report.runs.size(); ++r) {
    std::vector<double> values, low, high;
    bool known = sigma != nullptr;
    for (const Passage& place : report.along) {
      const Crossing& c = place.runs[r];
      values.push_back(c.*of);
      if (sigma == nullptr) continue;
      known = known && std::isfinite(c.*sigma);
      low.push_back(c.*of - c.*sigma);
      high.push_back(c.*of + c.*sigma);
    }
    if (known) plot.band(distance, low, high, static_cast<int>(r % 6), "");
    plot.line(distance, std::move(values), static_cast<int>(r % 6), report.runs[r]);
  }
  return as_figure(name, std::move(plot), fmt::format("{}.", title));
}

// Where a run crosses the plane at a place of the line.
Vector3d place_of(const Passage& place, std::size_t run) {
  const Vector3d right(place.direction.y(), -place.direction.x(), 0);
  return place.place + place.runs[run].offset * right;
}

std::string plan_of_course(const DescentReport& report, page::Drawing& drawing, const Plot& over) {
  Plot plot("Plan view: the runs and the gates", {"east [m]"}, {"north [m]"}, "Plan view of the runs with the gates");
  plot.equal_scale();
  constexpr int kHeight = 640;
  plot.size(Plot::kPageWidth, kHeight);
  std::vector<page::Drawing::Path> paths;
  for (std::size_t r = 0; r < report.runs.size(); ++r) {
    page::Drawing::Path path{.x = {}, .east = {}, .north = {}, .colour = static_cast<int>(r % 6)};
    for (const Passage& passage : report.along) {
      const Vector3d place = place_of(passage, r);
      if (!std::isfinite(place.x())) continue;
      path.x.push_back(passage.distance);
      path.east.push_back(place.x());
      path.north.push_back(place.y());
    }
    plot.line(path.east, path.north, path.colour, report.runs[r]);
    paths.push_back(std::move(path));
  }
  for (const Passage& gate : report.gates) plot.mark(gate.place.x(), gate.place.y(), 6, gate.name);
  return drawing.add_map(as_figure("plan_of_runs", std::move(plot), "Each run, and the gates."), over, paths);
}

}  // namespace

std::string descents_page(const DescentReport& report, const std::string& version) {
  std::string summary;
  for (std::size_t r = 1; r < report.runs.size(); ++r)
    summary += "<p><strong>" + escape_markup(most_text(report, r)) + "</strong></p>\n";
  if (!report.without_sigma.empty()) {
    summary +=
        "<p>Times gained have no sigma, as a folder has no covariance between two crossings: name "
        "configurations instead.</p>\n";
  }
  const std::string subtitle = fmt::format("piste {} · {} runs; the line is {}", escape_markup(version),
                                           report.runs.size(), escape_markup(report.how_line));
  page::Drawing drawing;
  const Figure gained = over_distance(report, "gained", "Time gained since the first gate", "[s]", &Crossing::gained,
                                      &Crossing::sigma_gained, 1);
  const std::string charts = drawing.add(
      {gained, over_distance(report, "speed", "Speed", "[m/s]", &Crossing::speed, nullptr, 0),
       over_distance(report, "offset", "Distance to the right of the line", "[m]", &Crossing::offset, nullptr, 0)});
  const std::string plan = plan_of_course(report, drawing, *gained.plot);
  return page::render(
      {.title = "Descents",
       .subtitle = subtitle,
       .head = drawing.head(),
       .sections = {{"lost", "Where time was lost",
                     summary +
                         "<p class=\"soft\">Where the time gained falls, it is being lost against the first run. Bands "
                         "are ± 1 sigma. Charts and plan have one cursor.</p>\n" +
                         charts + plan},
                    {"sections", "From gate to gate", section_table(report)}},
       .style = drawing.style(),
       .scripts = drawing.scripts()});
}

std::string descents_text(const DescentReport& report) {
  std::string text = fmt::format("the line is {}", report.how_line);
  for (std::size_t r = 1; r < report.runs.size(); ++r) {
    text += "\n" + most_text(report, r);
    for (const Section& s : report.sections) {
      text += fmt::format("\n  {} – {}: {:.3f} s, gained {} s", s.from, s.to, s.duration[r],
                          gained_text(s.gained[r], s.sigma[r]));
    }
  }
  return text;
}

}  // namespace piste
