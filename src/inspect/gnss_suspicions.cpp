// The words for faults of a GNSS log.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "adding_to.h"
#include "piste/inspect/gnss_health.h"
#include "velocity_fit.h"

namespace piste {
namespace {

constexpr double kFastest = 200, kSlowest = 0.05;  // Hz: limits of a receiver's rate

std::string column_names(const Matrix3d& axes) {
  constexpr std::array<std::string_view, 3> kPositive{"north", "east", "down"}, kNegative{"south", "west", "up"};
  std::string text;
  for (int row = 0; row < 3; ++row) {
    Eigen::Index column = 0;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    const auto name = static_cast<std::size_t>(column);
    text += fmt::format("{}{}", row > 0 ? ", " : "", axes(row, column) > 0 ? kPositive[name] : kNegative[name]);
  }
  return text;
}

void suspect_velocity(const VelocityFit& fit, const std::string& file, std::vector<Suspicion>& found) {
  const auto add = adding_to(found, file);
  constexpr double kLate = 0.03, kSure = 5;  // s; sigmas
  const std::string better = fmt::format("{:.2g} m/s off what the positions do where {:.2g} m/s are left so",
                                         fit.residual_as_given, fit.residual);
  const bool horizontal = fit.axes.topLeftCorner<2, 2>().isIdentity();
  if (fit.interchanged) {
    add(LogFault::kLatitudeLongitude,
        fmt::format("latitude and longitude are exchanged, it seems: the velocities{} fit the positions once they are "
                    "interchanged, {}",
                    horizontal ? "" : ", with north and east exchanged as well,", better),
        fmt::format("interchange the columns latitude_deg and longitude_deg{}",
                    horizontal ? "" : ", and those of the velocities north and east"));
  } else if (!horizontal) {
    add(LogFault::kVelocityEastNorth,
        fmt::format("the columns velocity north, east, down hold {}: {}", column_names(fit.axes), better),
        "name the columns for what they hold; `down` is minus `up`");
  } else if (!fit.axes.isIdentity()) {
    add(LogFault::kVelocityUp, "the velocity down is positive upwards: " + better,
        "reverse the sign of velocity_down_m_s");
  }
  if (fit.scale != 1) {
    add(LogFault::kVelocityUnit,
        fmt::format("the velocities are {:.3f} times what the positions do: {}, it seems; {}", fit.scale,
                    speed_unit_name(fit.scale), better),
        fmt::format("divide the velocities and their sigmas by {:.4f}", fit.scale));
  }
  if (fit.as_given() && std::abs(fit.delay) > kLate && std::abs(fit.delay) > kSure * fit.sigma_delay) {
    add(LogFault::kVelocityDelay,
        fmt::format("the velocities come {:.3f} ± {:.3f} s {} against the positions", std::abs(fit.delay),
                    fit.sigma_delay, fit.delay > 0 ? "late" : "early"),
        fmt::format("say so in its `gnss:` source: `velocity_delay: {:.3f} s`", fit.delay));
  }
}

void suspect_sigma(const GnssHealth& h, const std::string& file, std::vector<Suspicion>& found) {
  const auto add = adding_to(found, file);
  constexpr double kSmall = 3, kSmallAtRest = 4, kLarge = 10, kSway = 0.05;  // ratios; m
  const Vector3d claimed = h.median_sigma;
  if (h.without_sigma > 0) {
    add(LogFault::kSigmaTooSmall, fmt::format("{} of {} fixes claim a sigma of 0", h.without_sigma, h.sampling.rows),
        "give the receiver's own sigma, or leave these fixes out");
    return;
  }
  const Vector3d noise = h.noise.cwiseMax(0), rest = (h.rest_scatter.array() - kSway).cwiseMax(0).matrix();
  const double by_noise = h.noise.allFinite() ? noise.cwiseQuotient(claimed).maxCoeff() : 0;
  const double by_rest = h.rest_scatter.allFinite() ? rest.cwiseQuotient(claimed).maxCoeff() : 0;
  if (by_noise > kSmall || by_rest > kSmallAtRest) {
    const bool noisy = by_noise / kSmall > by_rest / kSmallAtRest;
    const Vector3d seen = noisy ? h.noise : h.rest_scatter;
    add(LogFault::kSigmaTooSmall,
        fmt::format("the positions {} by {:.3g} {:.3g} {:.3g} m (north, east, down) where {:.3g} {:.3g} "
                    "{:.3g} m are claimed",
                    noisy ? "scatter from fix to fix" : "wander at rest", seen.x(), seen.y(), seen.z(), claimed.x(),
                    claimed.y(), claimed.z()),
        fmt::format("multiply the sigmas by {:.2g}", std::max(by_noise, by_rest)));
  } else if (h.noise.allFinite() && h.rest_scatter.allFinite() &&
             (kLarge * noise.cwiseMax(h.rest_scatter).array() < claimed.array()).all()) {
    add(LogFault::kSigmaTooLarge,
        fmt::format("sigmas of {:.3g} {:.3g} {:.3g} m are claimed where the positions scatter by {:.2g} "
                    "{:.2g} {:.2g} m at rest",
                    claimed.x(), claimed.y(), claimed.z(), h.rest_scatter.x(), h.rest_scatter.y(), h.rest_scatter.z()),
        "nothing, where the receiver knows of errors that a short rest does not show");
  }
}

void suspect_positions(const GnssHealth& h, const std::string& file, std::vector<Suspicion>& found) {
  const auto add = adding_to(found, file);
  // Rounding alone makes fixes repeat, jump and scatter.
  const double rounding = h.quantum.head<2>().maxCoeff() / std::sqrt(12.0);
  if (rounding > 0.5 * h.median_sigma.head<2>().maxCoeff() && rounding > 0.005) {
    add(LogFault::kCoordinatesRounded,
        fmt::format("latitude and longitude are rounded to {:.3g} and {:.3g} m, where a sigma of {:.3g} m is claimed",
                    h.quantum.x(), h.quantum.y(), h.median_sigma.head<2>().maxCoeff()),
        "write degrees with nine decimals");
  } else {
    if (!h.repeated.empty()) {
      add(LogFault::kRepeatedFix,
          fmt::format("the same fix again and again while the antenna moves on, {} times; the first from t = {:.3f} to "
                      "{:.3f} s",
                      h.repeated.size(), h.repeated.front().start, h.repeated.front().end),
          "leave the repeated fixes out: the receiver had none");
    }
    if (!h.jumps.empty()) {
      const auto furthest =
          std::max_element(h.jumps.begin(), h.jumps.end(),
                           [](const PositionJump& a, const PositionJump& b) { return a.distance < b.distance; });
      add(LogFault::kPositionJumps,
          fmt::format(
              "{} positions jump, the furthest by {:.3g} m at t = {:.3f} s, where a sigma of {:.3g} m is claimed",
              h.jumps.size(), furthest->distance, furthest->time, h.median_sigma.maxCoeff()),
          "multipath, or a change of solution: the gate of replay rejects single ones; leave longer stretches out");
    }
    suspect_sigma(h, file, found);
  }
}

}  // namespace

std::vector<Suspicion> suspicions(const GnssHealth& h, const RowFaults& faults, const std::string& file) {
  std::vector<Suspicion> found = suspicions(h.sampling, faults, file, kFastest, kSlowest);
  const auto has = [&](LogFault fault) {
    return std::any_of(found.begin(), found.end(), [fault](const Suspicion& s) { return s.fault == fault; });
  };
  if (has(LogFault::kEmpty) || has(LogFault::kTimeUnit)) return found;
  const auto add = adding_to(found, file);
  if (h.velocity) suspect_velocity(*h.velocity, file, found);
  suspect_positions(h, file, found);
  if (h.sampling.interval > kSparseFixes) {
    add(LogFault::kLowRate,
        fmt::format(
            "a fix every {:.3g} s: the track between them is unknown, so that it determines neither axes nor units "
            "of an IMU",
            h.sampling.interval),
        "log a fix a second or more; gravity gives down, and `axes` has the rest");
  }
  if (h.velocities == 0) {
    add(LogFault::kNoVelocity, "no velocities", "log the receiver's velocities where it has them");
  }
  if (h.top_speed < kSurelyMoving) {
    add(LogFault::kNoMotion, fmt::format("the antenna moves at {:.2g} m/s at most", h.top_speed),
        "without motion the heading is not found");
  }
  if (h.without_fix > 0) {
    add(LogFault::kNoFix, fmt::format("{} epochs without a fix, against {} with one", h.without_fix, h.sampling.rows),
        "see where the antenna did not see the sky");
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Suspicion& a, const Suspicion& b) { return a.fault < b.fault; });
  return found;
}

}  // namespace piste
