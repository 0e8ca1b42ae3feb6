#include "piste/report/evaluation_page.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "piste/math/units.h"
#include "plot/markup.h"
#include "plot/svg.h"
#include "plot/thin.h"
#include "report/drawing.h"
#include "report/page.h"

namespace piste {
namespace {

using page::Row;
using page::table;

constexpr std::size_t kDrawn = 3000;  // points of a curve
constexpr int kErrorHeight = 300;     // px

std::string stem(const std::string& file) {
  const std::filesystem::path path(file);
  return (path.parent_path().filename() / path.filename()).string();
}

std::string three_digits(double value) { return fmt::format("{:.3g}", value); }

Row statistics_row(std::string name, const ErrorStatistics& s, double factor) {
  Row row{std::move(name)};
  for (const double value : {s.rmse, s.mean, s.median, s.std, s.min, s.max})
    row.push_back(three_digits(factor * value));
  return row;
}

std::string statistics_table(const Evaluation& found) {
  std::vector<Row> rows{statistics_row("absolute, position [m]", found.ape, 1)};
  if (found.ape_rotation)
    rows.push_back(statistics_row("absolute, rotation [deg]", *found.ape_rotation, kDegreesPerRadian));
  for (const RelativeErrors& r : found.rpe) {
    if (!r.distance) {
      rows.push_back({fmt::format("over {}", r.step.name()), "no pair"});
      rows.back().resize(7);
      continue;
    }
    rows.push_back(statistics_row(fmt::format("over {}, {} pairs [m]", r.step.name(), r.pairs), *r.distance, 1));
    if (r.rotation) {
      rows.push_back(
          statistics_row(fmt::format("over {}, rotation [deg]", r.step.name()), *r.rotation, kDegreesPerRadian));
    }
  }
  return table("Errors", {"", "RMSE", "mean", "median", "std", "least", "most"}, rows) +
         table("Horizontal errors", {"share", "within [m]"},
               {{"50 % (CEP)", three_digits(found.cep50)}, {"95 %", three_digits(found.cep95)}});
}

std::string share_table(const Evaluation& found) {
  if (!found.has_sigmas()) return "<p>The estimate states no sigma.</p>\n";
  std::vector<Row> rows{{"normal errors", ".683", ".954", ".997"}};
  for (std::size_t i = 0; i < kNavigationErrors; ++i) {
    const auto& share = found.within_sigma[i];
    if (std::isnan(share[0])) continue;
    Row row{std::string(navigation_error_name(i))};
    for (const double s : share) row.push_back(fmt::format("{:.3f}", s));
    rows.push_back(std::move(row));
  }
  return table("Share of errors within 1, 2 and 3 sigma of the estimate", {"", "1σ", "2σ", "3σ"}, rows);
}

std::string plan(const Evaluation& found) {
  Plot plot("Plan view, after the alignment", {"east [m]"}, {"north [m]"},
            "Plan view of both tracks, east against north in metres");
  plot.equal_scale();
  constexpr int kHeight = 640;
  plot.size(Plot::kPageWidth, kHeight);
  int colour = 1;
  for (const auto& [name, track] :
       {std::pair{"reference", &found.track_reference}, {"estimate", &found.track_estimate}}) {
    std::array<std::vector<double>, 2> all, drawn;
    for (const Vector3d& p : *track) {
      all[0].push_back(p.x());
      all[1].push_back(p.y());
    }
    for (const std::size_t i : thin(all, kDrawn)) {
      for (std::size_t k = 0; k < 2; ++k) drawn[k].push_back(all[k][i]);
    }
    plot.line(std::move(drawn[0]), std::move(drawn[1]), colour--, name);
  }
  return "<figure>\n" + plot.render() + "</figure>\n";
}

// The errors of one quantity over time, each with its band of ± 1 sigma, if there is one.
std::vector<Figure> errors_over_time(const Evaluation& found, std::size_t first, const std::string& title,
                                     const std::string& unit, double factor) {
  constexpr std::array<std::string_view, 3> kWays{"north", "east", "down"}, kAngles{"roll", "pitch", "heading"};
  if (std::isnan(found.rows.front().error[first])) return {};
  std::vector<Figure> out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(first == 6 ? kAngles[axis] : kWays[axis]);
    Plot plot(fmt::format("{}: {}", title, name), {"time_s [s]"}, {unit}, fmt::format("Error of {} over time", name));
    plot.size(Plot::kPageWidth, kErrorHeight);
    std::vector<double> time, error, low, high;
    for (const ErrorRow& row : found.rows) {
      time.push_back(row.time);
      error.push_back(factor * row.error[first + axis]);
      high.push_back(factor * row.sigma[first + axis]);
      low.push_back(-high.back());
    }
    constexpr int kBand = 6;
    if (!std::isnan(high.front())) plot.band(time, low, high, kBand, "± 1 sigma of the estimate");
    plot.line(std::move(time), std::move(error), 0, "estimate − reference");
    out.push_back(
        as_figure(fmt::format("{}_{}", title, name), std::move(plot), fmt::format("Error of {} over time.", name)));
  }
  return out;
}

std::string alignment_text(const Evaluation& found) {
  const Similarity& motion = found.alignment;
  const double angle = Eigen::AngleAxisd(motion.rotation).angle();
  std::string text = fmt::format("Alignment {}", name_of(found.options.align));
  if (found.options.align != AlignmentKind::kNone) {
    text += fmt::format(": moved by {:.4g} m, turned by {:.4g} deg, scale {:.8g}", motion.translation.norm(),
                        kDegreesPerRadian * angle, motion.scale);
  }
  if (found.options.find_offset) {
    text += fmt::format("; time offset {:.6f} ± {:.6f} s", found.time_offset, found.sigma_time_offset);
  }
  return text;
}

std::string compared_text(const Evaluation& found) {
  std::string text =
      fmt::format("{} epochs of {} against {}", found.rows.size(), stem(found.estimate), stem(found.reference));
  if (found.in_gaps > 0) text += fmt::format("; {} left out in gaps of more than 1 s", found.in_gaps);
  if (found.outside > 0) text += fmt::format("; {} outside the other's span", found.outside);
  return text;
}

}  // namespace

std::string evaluation_page(const Evaluation& found, const std::string& version) {
  const std::string subtitle = fmt::format("piste {} · {}. {}.", escape_markup(version),
                                           escape_markup(compared_text(found)), escape_markup(alignment_text(found)));
  std::vector<page::Section> sections{
      {"errors", "Errors", "<div class=\"tables\">\n" + statistics_table(found) + "</div>\n"},
      {"sigmas", "Sigmas", share_table(found)},
      {"plan", "Plan", plan(found)}};
  page::Drawing drawing;
  const auto add = [&](const char* name, const char* heading, const std::vector<Figure>& figures) {
    if (!figures.empty()) sections.push_back({name, heading, drawing.add(figures)});
  };
  add("position", "Position over time", errors_over_time(found, 0, "Position", "[m]", 1));
  add("velocity", "Velocity over time", errors_over_time(found, 3, "Velocity", "[m/s]", 1));
  add("attitude", "Attitude over time", errors_over_time(found, 6, "Attitude", "[deg]", kDegreesPerRadian));
  return page::render({.title = "Evaluation",
                       .subtitle = subtitle,
                       .head = drawing.head(),
                       .sections = std::move(sections),
                       .style = drawing.style(),
                       .scripts = drawing.scripts()});
}

std::string evaluation_text(const Evaluation& found) {
  std::string text = compared_text(found) + "\n" + alignment_text(found) + "\n";
  const auto line = [&](const std::string& name, const ErrorStatistics& s, double factor, std::string_view unit) {
    text += fmt::format("{:<22} rmse {:>9.4g}   mean {:>9.4g}   median {:>9.4g}   most {:>9.4g} {}\n", name,
                        factor * s.rmse, factor * s.mean, factor * s.median, factor * s.max, unit);
  };
  line("absolute", found.ape, 1, "m");
  if (found.ape_rotation) line("absolute rotation", *found.ape_rotation, kDegreesPerRadian, "deg");
  for (const RelativeErrors& r : found.rpe) {
    if (!r.distance) {
      text += fmt::format("over {}: the run is too short for a pair\n", r.step.name());
      continue;
    }
    line(fmt::format("over {}, {} pairs", r.step.name(), r.pairs), *r.distance, 1, "m");
    if (r.rotation) line(fmt::format("over {}, rotation", r.step.name()), *r.rotation, kDegreesPerRadian, "deg");
  }
  text += fmt::format("horizontal: 50 % within {:.4g} m, 95 % within {:.4g} m\n", found.cep50, found.cep95);
  for (std::size_t i = 0; i < kNavigationErrors; ++i) {
    const auto& s = found.within_sigma[i];
    if (std::isnan(s[0])) continue;
    text +=
        fmt::format("{:<22} {:.3f} {:.3f} {:.3f} within 1, 2, 3 sigma\n", navigation_error_name(i), s[0], s[1], s[2]);
  }
  if (found.nees) text += fmt::format("NEES per state {:.3f}\n", *found.nees);
  text.pop_back();
  return text;
}

}  // namespace piste
