#include "start_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "piste/core/error.h"
#include "piste/math/linear_algebra.h"
#include "piste/model/alignment.h"
#include "piste/solve/rts.h"
#include "stretch.h"

namespace piste {
namespace {

constexpr double kWindows[] = {3, 5, 8, 12};   // lengths of motion to align in [s], shortest first
constexpr double kHeadingKnown = 4 * kDegree;  // 1-sigma below which an alignment in motion is used
constexpr double kTiltKnown = 8 * kDegree;
constexpr double kLeastMotion = 1;  // s of a window that must not be known to be rest
constexpr double kStretch = 40;     // s filtered and smoothed after the alignment
// The smoothed covariance becomes the prior of a filter that uses the same stretch again, so its information would
// count twice. Multiplied by five, a fifth of it still counts twice: over 100 runs the sigmas are some 5 % too small,
// and the filter keeps most of what the smoother found. With a factor of two, those of the scales were 12 % too small.
constexpr double kTempering = 5;

// Seconds of a window that are not known to be rest. At rest an unknown gyro bias rotates gravity, which dead reckoning
// takes for motion: a false heading would result.
double moving_time(const Log& log, const Interval& window) {
  double time = window.end - window.start;
  for (const Interval& rest : log.rest) time -= overlap(rest, window);
  return time;
}

// The first window whose motion determines the whole attitude.
std::optional<MotionAlignment> first_alignment(const Log& log, const FilterOptions& options, const Receiver& receiver,
                                               double from) {
  const auto& fixes = receiver.fixes;
  double last_end = -1e300;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const double begin = fixes[i].time;
    if (begin < from || begin - last_end < 0.5) continue;
    last_end = begin;
    for (const double length : kWindows) {
      const auto window = range(fixes, begin, begin + length + 1e-6);
      if (window.empty() || window.back().time < begin + length - 1) break;
      if (moving_time(log, {begin, begin + length}) < kLeastMotion) continue;
      const auto imu = range(log.imu, begin, begin + length + 1);
      auto found = align_in_motion(imu, window, receiver.options, bias_before(log, options, begin),
                                   log.world.gravity(fixes[i].position).value);
      if (!found) continue;
      const Vector3d sigma = found->covariance.diagonal().cwiseSqrt();
      if (sigma.z() < kHeadingKnown && sigma.head<2>().maxCoeff() < kTiltKnown) return found;
    }
  }
  return std::nullopt;
}

// The smoothed state at the start of a stretch, and the smoothed heading at the departure. The latter is needed because
// between the two, at rest, no fix observes the heading, and it wanders with the gyroscope's drift. Its sigma is
// doubled, which leaves a quarter of the information, as the filter uses the same motion again.
struct Refined {
  SmoothedState start;
  std::optional<HeadingFix> heading;
};

// The row at the end of the rest before the motion.
std::optional<std::size_t> row_at_departure(const Log& log, const Solution& stretch, double aligned) {
  for (const Interval& rest : log.rest) {
    if (rest.end < aligned || rest.end > aligned + kWindows[3]) continue;
    std::size_t i = 0;
    while (i + 1 < stretch.size() && stretch.time(i) < rest.end) ++i;
    return i;
  }
  return std::nullopt;
}

Refined refine(const Log& log, const FilterOptions& options, const Start& start, double aligned) {
  const FilterRun run = run_filter(log, options, start, kCheckpointEvery, {}, aligned + kStretch);
  const std::optional<std::size_t> departure = row_at_departure(log, run.solution, aligned);
  Refined refined;
  const auto heading = [&](std::size_t, const Tape::Epoch& epoch, const SmoothedState& s) {
    refined.heading = {epoch.time, s.x.q_wb, 2 * sigmas_of(s.x, run.solution.layout(), s.P).euler.z()};
  };
  smooth_rows(log, run, departure ? std::vector{*departure} : std::vector<std::size_t>{}, heading, &refined.start);
  return refined;
}

// The smoothed covariance times kTempering, but in no direction larger than `prior`, the covariance before the stretch.
// The directions are those of the generalised eigenvalues of the two. The whole matrix is kept, with the correlations
// that a rest makes. A state whose prior variance is zero, such as a random walk at its start, stays known.
Covariance tempered(const Covariance& smoothed, const Covariance& prior) {
  std::vector<int> unknown;
  for (int i = 0; i < prior.rows(); ++i) {
    if (prior(i, i) > 0) unknown.push_back(i);
  }
  const Eigen::MatrixXd before = prior(unknown, unknown), after = smoothed(unknown, unknown);
  const Eigensystem found = eigensystem(after, before);
  const Eigen::MatrixXd axes = before * found.vectors;
  const Eigen::VectorXd part = (kTempering * found.values).cwiseMin(1);
  Covariance out = Covariance::Zero(prior.rows(), prior.cols());
  out(unknown, unknown) = axes * part.asDiagonal() * axes.transpose();
  return out;
}

// The start of a filter at the beginning of the window in which the motion was aligned.
Start moving_start(const Log& log, const FilterOptions& options, const Receiver& receiver,
                   const MotionAlignment& aligned) {
  Start moving{aligned.time, {}, Covariance::Identity(9, 9)};
  set_delays(moving.x, options);
  moving.x.q_wb = aligned.q_wb;
  place(moving, receiver, false);
  moving.x.v_wb = aligned.v_wb;
  set_attitude_sigma(moving, (2 * aligned.covariance.diagonal().cwiseSqrt()).cwiseMax(kTiltSigma));
  set_boresight(moving, log, options);
  return moving;
}

// The attitude at the start of the log, and the 1-sigma of its heading.
struct CarriedAttitude {
  Quaterniond q_wb;
  double heading_sigma;
};

// The attitude of `first`, which was smoothed at the time `aligned`, carried back to the time `begin`.
CarriedAttitude carried_back(const Log& log, const FilterOptions& options, const SmoothedState& first, double begin,
                             double aligned) {
  // If the rest is long, its own mean rate is the best bias, as it contains a slow rotation of the body too.
  GyroBias bias = bias_before(log, options, aligned);
  const Sigmas known = sigmas_of(first.x, StateLayout(options.estimate), first.P);
  if (bias.sigma > known.gyro_total_bias.norm()) {
    bias = {first.x.gyro_bias + first.x.gyro_drift, known.gyro_total_bias.norm()};
  }
  const double lapse = aligned - begin;
  const double walk = options.sensor.gyro.noise * std::sqrt(lapse);
  const double turn = std::sqrt(first.P(8, 8));  // about w's down axis
  return {carry_back(log, first.x.q_wb, begin, aligned, bias.value),
          std::clamp(std::hypot(2 * turn, walk, bias.sigma * lapse), 2 * kDegree, 15 * kDegree)};
}

}  // namespace

FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, Start start,
                             const std::optional<Rest>& rest) {
  const auto aligned = first_alignment(log, options, receiver, start.time);
  if (!aligned) {
    throw DataError("start",
                    "the heading cannot be found: no stretch of the log changes its horizontal velocity enough "
                    "while GNSS is there; give `initial: {heading: … deg}`, or use from_attitude or from_magnetometer");
  }
  const Start moving = moving_start(log, options, receiver, *aligned);
  const SmoothedState first = refine(log, options, moving, aligned->time).start;
  const CarriedAttitude carried = carried_back(log, options, first, start.time, aligned->time);
  start.x.q_wb = rest ? levelled(carried.q_wb, -rest->mean_force) : carried.q_wb;
  place(start, receiver, rest.has_value());
  if (!rest && aligned->time - start.time < 1) start.x.v_wb = aligned->v_wb;
  set_attitude_sigma(start, {kTiltSigma, kTiltSigma, carried.heading_sigma});
  set_boresight(start, log, options);

  // A second stretch, from the start itself.
  const Refined refined = refine(log, options, start, aligned->time);
  start.covariance = tempered(refined.start.P, initial_covariance(StateLayout(options.estimate), options, start));
  start.x = refined.start.x;
  start.heading = refined.heading;
  const double sigma = euler_sigma(start.x.q_wb, start.covariance.block<3, 3>(6, 6)).z();
  return {start, fmt::format("heading {:.1f} deg ± {:.2f}, found from the motion at t = {:.1f} s",
                             to_euler(start.x.q_wb).z() / kDegree, sigma / kDegree, aligned->time)};
}

}  // namespace piste
