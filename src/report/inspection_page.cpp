#include "piste/report/inspection_page.h"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/math/earth.h"
#include "piste/math/units.h"
#include "piste/report/inspection_text.h"
#include "plot/markup.h"
#include "plot/svg.h"
#include "plot/thin.h"
#include "report/page.h"

namespace piste {
namespace {

constexpr int kLogHeight = 300;  // px
enum LogColour { kFirstColour, kSecondColour, kThirdColour, kGapColour = 4, kRestColour = 5 };

// Curves over the time since the log's first row.
struct Curves {
  std::string title, unit;
  std::vector<std::string> names;
  std::vector<double> time = {};
  std::vector<std::vector<double>> values = std::vector<std::vector<double>>(names.size());  // as many as names

  void add(double t, const Vector3d& v) {
    time.push_back(t);
    for (std::size_t i = 0; i < values.size(); ++i) values[i].push_back(v(static_cast<Eigen::Index>(i)));
  }
};

Figure figure_of(Curves curves, const std::string& name, const std::vector<Interval>& rest,
                 const std::vector<Interval>& gaps, const std::string& caption) {
  const auto kept = thin(curves.values, kCurvePoints);
  const auto pick = [&](const std::vector<double>& all) {
    std::vector<double> some;
    some.reserve(kept.size());
    for (const std::size_t i : kept) some.push_back(all[i]);
    return some;
  };
  const double first = curves.time.front();
  Plot plot(curves.title, {fmt::format("time after {:.3f} s [s]", first)}, {curves.unit});
  plot.size(Plot::kPageWidth, kLogHeight);
  for (const Interval& r : rest)
    plot.shade(r.start - first, r.end - first, kRestColour, &r == rest.data() ? "rest" : "");
  for (const Interval& g : gaps) plot.shade(g.start - first, g.end - first, kGapColour, &g == gaps.data() ? "gap" : "");
  std::vector<double> time = pick(curves.time);
  for (double& t : time) t -= first;
  for (std::size_t i = 0; i < curves.values.size(); ++i)
    plot.line(time, pick(curves.values[i]), static_cast<int>(i), curves.names[i]);
  return {name, plot.render(), caption};
}

std::vector<Figure> imu_figures(const InspectedLog& log, std::size_t number) {
  const ImuRecording& imu = log.imu;
  const Sampling& s = log.imu_health->sampling;
  const auto curves = [&](const std::vector<Vector3d>& values, const std::string& title, const std::string& unit,
                          double factor) {
    Curves c{title, unit, {"x", "y", "z"}};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double per = !imu.increments ? 1 : i > 0 ? imu.time[i] - imu.time[i - 1] : s.interval;
      c.add(imu.time[i], factor / per * values[i]);
    }
    return c;
  };
  return {figure_of(curves(imu.gyro, "Angular rate, sensor axes, as labelled", "deg/s", kDegreesPerRadian),
                    fmt::format("rate_{}", number), log.imu_health->rest, s.gaps, ""),
          figure_of(curves(imu.accel, "Specific force, sensor axes, as labelled", "m/s²", 1),
                    fmt::format("force_{}", number), log.imu_health->rest, s.gaps,
                    "At rest the axis that points down reads −9.8 m/s².")};
}

std::vector<Figure> gnss_figures(const InspectedLog& log, std::size_t number) {
  const std::vector<GeodeticFix>& fixes = log.gnss.fixes;
  const World world(fixes.front().position);
  std::vector<double> north, east;
  Curves height{"Height", "m", {"above the ellipsoid"}}, sigma{"Sigma of the position", "m", {"north", "east", "down"}},
      velocity{"Velocity", "m/s", {"north", "east", "down"}};
  for (const GeodeticFix& fix : fixes) {
    const Vector3d p = world.from_geodetic(fix.position);
    north.push_back(p.x());
    east.push_back(p.y());
    height.add(fix.time, Vector3d::Constant(fix.position.height));
    sigma.add(fix.time, fix.sigma_position);
    if (fix.velocity) velocity.add(fix.time, fix.velocity->value);
  }
  const std::array<std::vector<double>, 2> track{north, east};
  Plot map("Track", {"east [m]"}, {"north [m]"});
  map.equal_scale();
  std::vector<double> some_north, some_east;
  for (const std::size_t i : thin(track, kCurvePoints)) {
    some_north.push_back(north[i]);
    some_east.push_back(east[i]);
  }
  map.line(some_east, some_north, kFirstColour, "");
  map.mark(east.front(), north.front(), kSecondColour, "start");
  std::vector<Figure> figures{{fmt::format("track_{}", number), map.render(), ""}};
  const Sampling& s = log.gnss_health->sampling;
  figures.push_back(figure_of(std::move(height), fmt::format("height_{}", number), log.gnss_health->rest, s.gaps, ""));
  if (velocity.time.size() > 1) {
    figures.push_back(
        figure_of(std::move(velocity), fmt::format("velocity_{}", number), log.gnss_health->rest, s.gaps, ""));
  }
  figures.push_back(figure_of(std::move(sigma), fmt::format("sigma_{}", number), log.gnss_health->rest, s.gaps, ""));
  return figures;
}

std::string suspicions_body(const std::vector<Suspicion>& suspicions) {
  if (suspicions.empty()) return "<p>Nothing looks wrong.</p>\n";
  std::string out;
  const auto items = [&](bool severe, std::string_view heading) {
    std::vector<std::string> list;
    for (const Suspicion& s : suspicions) {
      if (is_severe(s.fault) == severe) list.push_back(fmt::format("{}: {} — {}", s.file, s.what, s.remedy));
    }
    out += page::list(heading, list);
  };
  items(true, "To be corrected, the worst first:");
  items(false, "Worth knowing:");
  return out;
}

std::string sheet_table(const InspectionSheet& sheet) {
  std::string out = fmt::format("<div class=\"wide\">\n<table><caption>{}</caption>\n", escape_markup(sheet.title));
  for (const auto& [name, text] : sheet.facts)
    out += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape_markup(name), escape_markup(text));
  return out + "</table>\n</div>\n";
}

}  // namespace

std::string inspection_page(const Inspection& inspection, const std::optional<std::string>& config,
                            const std::string& version) {
  std::vector<page::Section> sections{{"wrong", "What looks wrong", suspicions_body(inspection.suspicions)}};
  const std::vector<InspectionSheet> sheets = inspection_sheets(inspection);
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    page::Section section{fmt::format("log_{}", i + 1), "", sheet_table(sheets[i])};
    if (i < inspection.logs.size()) {
      const InspectedLog& log = inspection.logs[i];
      section.heading = fmt::format("Log {}{}", i + 1, log.guess ? fmt::format(": {}", name_of(log.guess->kind)) : "");
      if (log.imu_health) section.body += page::pictures(imu_figures(log, i + 1));
      if (log.gnss_health) section.body += page::pictures(gnss_figures(log, i + 1));
    } else {
      section.heading = fmt::format("Match {}", i + 1 - inspection.logs.size());
    }
    sections.push_back(std::move(section));
  }
  if (config) {
    sections.push_back(
        {"configuration", "A configuration for replay", fmt::format("<pre>{}</pre>\n", escape_markup(*config))});
  }
  return page::render({.title = "Inspection",
                       .subtitle = fmt::format("piste {} · {} logs", escape_markup(version), inspection.logs.size()),
                       .sections = sections});
}

}  // namespace piste
