#include "diagnosis/left_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/time_search.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kTooMany = 0.2;     // part of the measurements: more are no outliers
constexpr std::size_t kFewest = 30;  // measurements: with fewer that is chance

// A sensor that is not a receiver or a reference attitude, and what mostly is wrong where it contradicts the rest.
struct Aid {
  std::string_view source, unit;
  double factor;  // from SI to that unit
  std::string_view advice;
};
constexpr std::array kAids{
    Aid{"odometer", "m/s", 1, "check its unit, its sign with `signed: true`, and `sigma`"},
    Aid{"barometer", "m", 1, "check its unit, and with `drift: {sigma}` how far its offset may be off"},
    Aid{"heading", "deg", kDegreesPerRadian, "check its unit, and which way `baseline` points"},
    Aid{"magnetometer", "uT", 1, "check its `unit`, its axes, and the iron near by"},
    Aid{"vehicle.right", "m/s", 1, "does it slide, or is it none? Check `mounting` and `contact`, or leave it out"},
    Aid{"vehicle.down", "m/s", 1, "does it jump, or is it none? Check `mounting` and `contact`, or leave it out"},
};

bool at_rest(const Log& log, double time) {
  return std::ranges::any_of(log.rest, [&](const Interval& rest) { return rest.contains(time); });
}

// The ratio of the odometer's speed to that of the run; nothing at a walk.
std::optional<double> speed_ratio(const Log& log, const Innovation& v) {
  constexpr double kWalk = 1, kSameTime = 1e-6;  // m/s, s
  const double measured_at = v.time + v.late;
  const auto fix = first_at_or_after(log.speed, measured_at - kSameTime);
  if (fix == log.speed.end() || fix->time > measured_at + kSameTime) return std::nullopt;
  const double speed = fix->speed - v.residual.x();
  return std::abs(speed) > kWalk ? std::optional(fix->speed / speed) : std::nullopt;
}

}  // namespace

std::vector<std::string> left_out_lines(const Log& log, const Solution& filtered) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < log.counts.gnss_contradicted.size(); ++i) {
    const FirstFixes& first = log.counts.gnss_contradicted[i];
    if (first.count == 0) continue;
    lines.push_back(
        fmt::format("gnss[{}]: the first {} positions are {:.3g} m off where the later ones begin; they count "
                    "as that uncertain",
                    i, first.count, first.off));
  }
  for (std::size_t i = 0; i < log.counts.gnss_ramps.size(); ++i) {
    const std::string velocities = fmt::format("gnss[{}].velocity", i);
    const bool used = std::ranges::any_of(filtered.innovations, [&](const Innovation& v) {
      return filtered.sources[static_cast<std::size_t>(v.source)] == velocities;
    });
    if (!used) continue;
    for (const RampFault& ramp : log.counts.gnss_ramps[i]) {
      lines.push_back(fmt::format(
          "gnss[{}]: from {:.1f} to {:.1f} s its positions run away from its own velocities, up to {:.3g} m; "
          "these {} positions are left out",
          i, ramp.span.start, ramp.span.end, ramp.off, ramp.count));
    }
  }
  for (const Aid& aid : kAids) {
    const auto source = std::ranges::find(filtered.sources, aid.source);
    if (source == filtered.sources.end()) continue;
    const auto index = static_cast<int>(source - filtered.sources.begin());
    std::size_t all = 0;
    bool compared = false;  // at rest or under way
    std::vector<double> sizes, ratios;
    for (const Innovation& v : filtered.innovations) {
      if (v.source != index) continue;
      compared = true;
      if (at_rest(log, v.time)) continue;
      ++all;
      if (was_used(v.outcome)) continue;
      sizes.push_back(aid.factor * v.residual.head(v.dof).norm());
      if (aid.source != "odometer") continue;
      if (const auto ratio = speed_ratio(log, v)) ratios.push_back(*ratio);
    }
    if (aid.source == "heading" && !compared && log.heading.size() >= kFewest) {
      lines.emplace_back(
          "heading: nothing of it was used, as its baseline stands upright and has no azimuth; check `baseline`");
    }
    if (all < kFewest || static_cast<double>(sizes.size()) < kTooMany * static_cast<double>(all)) continue;
    const std::size_t out = sizes.size();
    const std::string times =
        ratios.empty() ? "" : fmt::format(", {:.2g} times the speed of the run", median(std::move(ratios)));
    lines.push_back(
        fmt::format("{}: {} of {} measurements under way were left out, off by {:.3g} {} in the median{}; {}",
                    aid.source, out, all, median(std::move(sizes)), aid.unit, times, aid.advice));
  }
  return lines;
}

}  // namespace piste
