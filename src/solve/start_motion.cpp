#include "start_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "feeder.h"
#include "piste/core/error.h"
#include "piste/model/alignment.h"
#include "piste/solve/heading_bank.h"
#include "piste/solve/rts.h"
#include "stretch.h"

namespace piste {
namespace {

constexpr int kHypotheses = 12;
// 1-sigma of each. The truth is at most half of it away from the middle of the nearest.
constexpr double kSpacing = 2 * std::numbers::pi / kHypotheses, kHypothesisSigma = kSpacing / 2;
constexpr double kListened = 30;  // s of the rest before the departure that the bank filters
constexpr double kFurther = 40;   // s of motion after which attitude and biases are sure
constexpr double kLeastSigma = 1 * kDegree;
constexpr double kStill = 3;  // sigmas

// Where a receiver shows that the body has left its place.
struct Departure {
  bool seen = false;
  std::optional<Rest> before;  // the end of the last rest before it; none if the body moves from the beginning
};

Departure departure_from(const Log& log, const Receiver& receiver, double from) {
  const auto& fixes = receiver.fixes;
  const auto first = first_at_or_after(fixes, from);
  Departure found;
  double departure = log.imu.back().time;
  for (auto fix = first; fix != fixes.end(); ++fix) {
    const double far = 2 + 2 * kStill * (first->sigma_position + fix->sigma_position).norm();
    if ((fix->position - first->position).norm() < far) continue;
    departure = fix->time;
    found.seen = true;
    break;
  }
  for (const Interval& rest : log.rest) {
    if (rest.start < departure && rest.end > from)
      found.before = average(log, {std::max({rest.start, from, rest.end - kListened}), rest.end});
  }
  return found;
}

// A start at rest with the given heading.
Start still_start(const Log& log, const FilterOptions& options, const Receiver& receiver, const Rest& rest,
                  double heading) {
  Start start;
  set_delays(start.x, options);
  start.time = rest.interval.start;
  start.x.q_wb = (local_level(log.world, receiver, start.time) * level(rest.mean_force, heading)).normalized();
  place_at_rest(log.world, start, receiver);
  set_attitude_sigma(log.world, start, {kTiltSigma, kTiltSigma, kHypothesisSigma});
  set_boresight(start, log, options);
  return start;
}

// What the bank found.
struct FoundHeading {
  Start start;  // the likeliest hypothesis
  double until = 0;
  bool resolved = false;
};

FoundHeading ask_the_bank(const Log& log, const FilterOptions& options, const std::vector<Start>& hypotheses) {
  HeadingBank bank(options, log.world, hypotheses);
  LogPlace place = place_at(log, hypotheses.front().time, 1e300);
  Feeder feeder(log, place, bank);
  while (!feeder.done() && !bank.resolved()) feeder.step();
  FoundHeading found{.start = hypotheses[bank.best_start()], .until = bank.best().time(), .resolved = bank.resolved()};
  if (!found.resolved) set_attitude_sigma(log.world, found.start, {kTiltSigma, kTiltSigma, bank.heading().sigma});
  return found;
}

// The same start with the smoothed attitude. Its sigmas stay those of the hypothesis where these are smaller.
FoundHeading refined(const Log& log, const FilterOptions& options, FoundHeading found) {
  const FilterRun run = run_filter(log, options, found.start, kCheckpointEvery, {}, found.until + kFurther);
  SmoothedState smoothed;
  smooth_rows(
      log, run, {}, [](std::size_t, const Tape::Epoch&, const SmoothedState&) {}, &smoothed);
  const Vector3d before = attitude_sigma(log.world, found.start);
  const Vector3d after = kLoose * attitude_sigma(log.world, {found.start.time, smoothed.x, smoothed.P});
  found.start.x.q_wb = smoothed.x.q_wb;
  set_attitude_sigma(log.world, found.start, after.cwiseMax(kLeastSigma).cwiseMin(before));
  set_boresight(found.start, log, options);
  return found;
}

// The start at the time `begin` of a body that stands until after the time of `found`.
Start carried_back(const Log& log, const FilterOptions& options, const Receiver& receiver, const FoundHeading& found,
                   double begin) {
  constexpr double kLongestRest = 10;  // s of rest that level the body
  const double lapse = found.start.time - begin;
  const GyroBias bias = bias_before(log, options, found.start.time);
  const double turned = std::hypot(options.sensor.gyro.noise * std::sqrt(lapse), bias.sigma * lapse);
  const double heading = attitude_sigma(log.world, found.start).z();
  const std::optional<Rest> rest = rest_at(log, begin, kLongestRest);
  Start start;
  set_delays(start.x, options);
  start.time = begin;
  start.x.q_wb = carry_back(log, found.start.x.q_wb, begin, found.start.time, bias.value);
  if (rest) {
    const Quaterniond q_wn = local_level(log.world, receiver, begin);
    start.x.q_wb = q_wn * levelled(q_wn.conjugate() * start.x.q_wb, -rest->mean_force);
  }
  place_at_rest(log.world, start, receiver);
  const double tilt = rest ? kTiltSigma : 5 * kTiltSigma;
  set_attitude_sigma(log.world, start,
                     {tilt, tilt, std::min(std::hypot(heading, turned), kHypothesisSigma * kHypotheses)});
  set_boresight(start, log, options);
  return start;
}

}  // namespace

std::vector<Start> heading_hypotheses(const Log& log, const FilterOptions& options, const Receiver& receiver,
                                      double begin) {
  const std::optional<Rest> departing = departure_from(log, receiver, begin).before;
  std::vector<Start> hypotheses;
  for (int k = 0; k < kHypotheses; ++k) {
    const double heading = k * kSpacing;
    hypotheses.push_back(departing ? still_start(log, options, receiver, *departing, heading)
                                   : start_on_the_move(log, options, receiver, begin, heading, kHypothesisSigma));
  }
  return hypotheses;
}

FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, double begin) {
  const auto [leaves, departing] = departure_from(log, receiver, begin);
  FoundHeading found = ask_the_bank(log, options, heading_hypotheses(log, options, receiver, begin));
  if (!found.resolved && !leaves) {
    throw DataError("start",
                    "the heading cannot be found: the body does not leave its place while GNSS is there; give "
                    "`initial: {heading: … deg}`, or use from_attitude or from_magnetometer");
  }
  if (found.resolved) found = refined(log, options, std::move(found));
  if (departing) found.start = carried_back(log, options, receiver, found, begin);
  const Matrix3d R_nw = log.world.rotation_wn(found.start.x.p_wb).transpose();
  const Quaterniond q_nb = Quaterniond(R_nw) * found.start.x.q_wb;
  const Matrix3d attitude = R_nw * found.start.covariance.block<3, 3>(6, 6) * R_nw.transpose();
  const double heading = to_euler(q_nb).z(), sigma = euler_sigma(q_nb, attitude).z();
  if (!found.resolved) {
    return {found.start,
            fmt::format("the heading is not known: the motion does not tell it; {:.0f} deg ± {:.0f} is the "
                        "likeliest, and `initial: {{heading: … deg}}` gives it",
                        heading / kDegree, sigma / kDegree)};
  }
  return {found.start,
          fmt::format("heading {:.1f} deg ± {:.2f}, found from the motion until t = {:.1f} s", heading / kDegree,
                      sigma / kDegree, found.until),
          found.until + kFurther};
}

}  // namespace piste
