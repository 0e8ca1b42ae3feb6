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

constexpr double kWindows[] = {3, 5, 8, 12};   // s of motion to align in, shortest first
constexpr double kHeadingKnown = 4 * kDegree;  // 1-sigma at which an alignment in motion is believed
constexpr double kTiltKnown = 8 * kDegree;
constexpr double kLeastMotion = 1;  // s that a window must hold beyond what is known to be rest
constexpr double kStretch = 40;     // s filtered and smoothed after the alignment
// A smoothed covariance becomes the prior of a filter that sees the same stretch again, and would count it twice. Five
// times as large, a fifth is counted again: over 100 runs sigmas are some 5 % small, and the filter keeps most of what
// the stretch foretold. Twice left those of the scales 12 % small.
constexpr double kTempering = 5;

// Seconds of a window in which the body may move. At rest an unknown gyro bias turns gravity, dead reckoning takes
// that for motion, and a heading comes out of nothing.
double moving_time(const Log& log, const Interval& window) {
  double time = window.end - window.start;
  for (const Interval& rest : log.rest) time -= overlap(rest, window);
  return time;
}

// The first window in which motion tells the whole attitude.
std::optional<MotionAlignment> first_alignment(const Log& log, const FilterOptions& options, const Receiver& receiver,
                                               double from) {
  const auto& fixes = *receiver.fixes;
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
      auto found = align_in_motion(imu, window, *receiver.options, bias_before(log, options, begin),
                                   log.world.gravity(fixes[i].position).value);
      if (!found) continue;
      const Vector3d sigma = found->covariance.diagonal().cwiseSqrt();
      if (sigma.z() < kHeadingKnown && sigma.head<2>().maxCoeff() < kTiltKnown) return found;
    }
  }
  return std::nullopt;
}

// What the smoother of a stretch says of its start, and of the heading at the departure: in between, a heading that no
// fix holds would wander by the gyro's drift. Twice its sigma: a quarter of the information, as the filter sees the
// motion again.
struct Refined {
  SmoothedState start;
  std::optional<HeadingFix> heading;
};

// The end of the rest that the motion ended.
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

// A smoothed covariance, kTempering times as large, but in no direction larger than `prior`, what was known before the
// stretch: by the eigenvalues of the one against the other. Whole, so that what a rest ties together stays tied. A
// state that was known before, such as a random walk at its start, stays known.
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

// Where the motion was aligned: the body moves, and knows its attitude from there on.
Start moving_start(const Log& log, const FilterOptions& options, const Receiver& receiver,
                   const MotionAlignment& aligned) {
  Start moving{aligned.time, {}, Covariance::Identity(9, 9)};
  moving.x.q_wb = aligned.q_wb;
  place(moving, receiver, false);
  moving.x.v_wb = aligned.v_wb;
  set_attitude_sigma(moving, (2 * aligned.covariance.diagonal().cwiseSqrt()).cwiseMax(kTiltSigma));
  set_boresight(moving, log, options);
  return moving;
}

// An attitude at the start, and the 1-sigma of its heading.
struct CarriedAttitude {
  Quaterniond q_wb;
  double heading_sigma;
};

// The attitude of `first`, smoothed at `aligned`, carried back to `begin`.
CarriedAttitude carried_back(const Log& log, const FilterOptions& options, const SmoothedState& first, double begin,
                             double aligned) {
  // By the rest's own mean rate where it is long, as that holds the slow turn of a body too.
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
