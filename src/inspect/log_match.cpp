#include "piste/inspect/log_match.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "clock_match.h"
#include "core/time_search.h"
#include "motion_match.h"
#include "piste/math/statistics.h"
#include "rest_match.h"
#include "velocity_fit.h"

namespace piste {
namespace {

// Stationary times determine an offset to about 1 s, as a receiver detects a slow start late.
constexpr double kNear = 5, kRestSigma = 0.6;         // s
constexpr double kSlowestImu = 2, kSlowestGnss = 20;  // s between rows: longer intervals mean another unit of time

bool times_are_seconds(const LogMatch& m, double gnss_interval) {
  return m.interval > 0 && m.interval < kSlowestImu && gnss_interval > 0 && gnss_interval < kSlowestGnss;
}

double median_force(const ImuRecording& imu, double interval) {
  std::vector<double> forces;
  forces.reserve(imu.accel.size());
  for (const Vector3d& f : imu.accel) forces.push_back(f.norm());
  return median(std::move(forces)) / (imu.increments ? interval : 1);
}

}  // namespace

std::string axes_text(const Matrix3d& axes) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    Eigen::Index axis = 0;
    axes.row(row).cwiseAbs().maxCoeff(&axis);
    text += fmt::format("{}{}{}", row > 0 ? " " : "", axes(row, axis) > 0 ? '+' : '-', static_cast<char>('x' + axis));
  }
  return text;
}

namespace {

// Estimates clock, axes and units with this track.
void compare(LogMatch& m, const ImuIntegral& integral, const Track& track, const GnssHealth& health,
             const std::vector<Interval>& rest) {
  m.clock = match_clocks(integral, track);
  if (health.sampling.interval > kSparseFixes) {
    if (m.clock && !m.clock->certain) m.clock.reset();
    if (m.clock) m.clock->sigma = clock_sigma(m.clock->sigma, health);
    return;
  }
  const auto compare_motion = [&] {
    const double offset = m.clock ? m.clock->offset : 0;
    m.turn_ratio = turn_ratio(integral, track, offset);
    m.motion = match_motion(integral, m.increments, track, health.rest, offset, m.turn_ratio);
  };
  compare_motion();
  const auto confirm = [&] {
    if (!m.clock || m.clock->certain || m.motion) return;
    m.clock.reset();
    compare_motion();
  };
  confirm();
  const std::optional<double> roughly =
      m.clock || m.motion ? std::nullopt : match_rests({rest, m.imu}, {health.rest, m.gnss});
  if (roughly) {
    m.clock = match_clocks(integral, track, Interval{*roughly - kNear, *roughly + kNear});
    if (m.clock) compare_motion();
    confirm();
    if (!m.clock) m.clock = ClockMatch{.offset = *roughly, .sigma = kRestSigma, .by_rest = true};
  }
  if (!m.clock || !m.clock->by_rest) {
    m.turn_correlation = turn_correlation(integral, track, m.clock ? m.clock->offset : 0);
  }
  if (m.clock && m.motion && m.motion->sigma_clock > 0) {
    m.clock->offset += m.motion->clock_rest;
    m.clock->sigma = m.motion->sigma_clock;
  }
  if (m.clock) m.clock->sigma = clock_sigma(m.clock->sigma, health);
}

// The comparison with latitude and longitude interchanged, if the labels fit that far better.
std::optional<LogMatch> compared_interchanged(const LogMatch& m, const ImuIntegral& integral, GnssRecording gnss,
                                              const GnssHealth& health, const std::vector<Interval>& rest) {
  constexpr double kClearly = 0.8;  // of the residual
  const bool fits = m.motion && m.motion->as_given() && m.turn_correlation > 0;
  if (fits || health.velocities > 0 || !may_be_interchanged(gnss.fixes)) return std::nullopt;
  gnss.fixes = interchanged(std::move(gnss.fixes));
  const GnssHealth other_health = gnss_health(gnss);
  LogMatch other = m;
  other.motion.reset();
  other.turn_correlation = 0;
  compare(other, integral, Track(gnss, other_health), other_health, rest);
  const bool as_given = other.motion && other.motion->as_given() && !(other.turn_correlation < 0);
  if (!as_given || (m.motion && other.motion->residual > kClearly * m.motion->residual)) return std::nullopt;
  other.interchanged = true;
  return other;
}

}  // namespace

LogMatch match(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health,
               const std::vector<Interval>& rest) {
  constexpr double kWellKnownDelay = 0.05;  // s
  LogMatch m;
  if (imu.time.size() < 3 || gnss.fixes.size() < 3) return m;
  const ImuIntegral integral(imu);
  m.imu = {imu.time.front(), imu.time.back()};
  m.gnss = {gnss.fixes.front().time, gnss.fixes.back().time};
  m.interval = integral.interval();
  m.increments = imu.increments;
  m.overlap = overlap(m.imu, m.gnss);
  if (!times_are_seconds(m, health.sampling.interval)) {
    m.interval = 0;
    return m;
  }
  m.velocities_may_be_late =
      health.velocities > 0 && !(health.velocity && health.velocity->sigma_delay < kWellKnownDelay);
  m.force = median_force(imu, m.interval);
  compare(m, integral, Track(gnss, health), health, rest);
  if (auto other = compared_interchanged(m, integral, gnss, health, rest)) return std::move(*other);
  return m;
}

}  // namespace piste
