#include "start/start_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "filter/feeder.h"
#include "model/alignment.h"
#include "piste/core/error.h"
#include "piste/smoother/rts.h"
#include "start/heading_search.h"
#include "start/stretch.h"

namespace piste {
namespace {

double spacing(const StartOptions& options) { return 2 * std::numbers::pi / options.hypotheses; }

// 1-sigma of each hypothesis. The truth is at most this far from the nearest one.
double hypothesis_sigma(const StartOptions& options) { return spacing(options) / 2; }

// Where a receiver shows that the body has departed.
struct Departure {
  bool seen = false;
  std::optional<Rest> before;  // end of the last rest before it; nothing if the body moves from the beginning
};

// The time of the first fix for which `far(first, fix)` holds.
template <class Far>
std::optional<double> first_far_fix(const Receiver& receiver, double from, Far&& far) {
  const auto& fixes = receiver.fixes;
  auto first = first_at_or_after(fixes, from);
  for (auto fix = first; fix != fixes.end(); ++fix) {
    constexpr double kFarSurer = 1.0 / 3;  // the first fixes may be inaccurate
    if (fix->sigma_position.norm() < kFarSurer * first->sigma_position.norm()) first = fix;
    if (far(*first, *fix)) return fix->time;
  }
  return std::nullopt;
}

Departure departure_from(const Log& log, const Receiver& receiver, double from, const StartOptions& options) {
  auto seen = first_far_fix(receiver, from, [&](const GnssFix& first, const GnssFix& fix) {
    const double far = options.departed + options.departed_sigmas * (first.sigma_position + fix.sigma_position).norm();
    return (fix.position - first.position).norm() >= far;
  });
  // A body that never comes so far, as with a phone's receiver on a short walk: in plan, by errors that are
  // independent.
  if (!seen) {
    seen = first_far_fix(receiver, from, [&](const GnssFix& first, const GnssFix& fix) {
      const double sigma =
          std::hypot(first.sigma_position.head<2>().maxCoeff(), fix.sigma_position.head<2>().maxCoeff());
      const Vector3d apart = log.world.rotation_wn(first.position).transpose() * (fix.position - first.position);
      return apart.head<2>().norm() >= options.departed + options.departed_sigmas * sigma;
    });
  }
  Departure found;
  found.seen = seen.has_value();
  const double departure = seen.value_or(log.imu.back().time);
  for (const Interval& rest : log.rest) {
    if (rest.start < departure && rest.end > from)
      found.before = average(log, {std::max({rest.start, from, rest.end - options.listened}), rest.end});
  }
  return found;
}

// A start at standstill with the given heading.
Start still_start(const Log& log, const FilterOptions& options, const Receiver& receiver, const Rest& rest,
                  double heading) {
  const StartOptions& o = options.behaviour.start;
  Start start;
  set_known(start.x, options);
  start.time = rest.interval.start;
  start.x.q_wb = (local_level(log.world, receiver, start.time) * level(rest.mean_force, heading)).normalized();
  place_at_rest(log.world, start, receiver, o);
  set_attitude_sigma(log.world, start, {o.tilt_sigma, o.tilt_sigma, hypothesis_sigma(o)});
  set_boresight(start, log, options);
  return start;
}

// Result of the heading search.
struct FoundHeading {
  Start start;  // of the most likely hypothesis
  double until = 0;
  bool resolved = false;
};

FoundHeading search_heading(const Log& log, const FilterOptions& options, const std::vector<Start>& hypotheses) {
  HeadingSearch search(options, log.world, hypotheses);
  const LogPart part{.rest_step = options.behaviour.start.rest_step};
  Feeder feeder(log, place_at(log, hypotheses.front().time, part), search);
  while (!feeder.done() && !search.resolved()) feeder.step();
  FoundHeading found{
      .start = hypotheses[search.best_start()], .until = search.best().time(), .resolved = search.resolved()};
  const double tilt = options.behaviour.start.tilt_sigma;
  if (!found.resolved) set_attitude_sigma(log.world, found.start, {tilt, tilt, search.heading().sigma});
  return found;
}

// The same start with the smoothed attitude. Its sigmas stay those of the hypothesis where these are smaller. It
// changes no result, and saves a pass of initial_stretch() over a standstill of any length.
FoundHeading refined(const Log& log, const FilterOptions& options, FoundHeading found) {
  const StartOptions& o = options.behaviour.start;
  const FilterRun run = run_filter(log, options, found.start, Keep::kHistory, {},
                                   {.end = found.until + o.look_back, .rest_step = o.rest_step});
  SmoothedState smoothed;
  smooth_rows(
      run, {}, [](std::size_t, const FilterState&, const SmoothedState&) {}, &smoothed);
  const Vector3d before = attitude_sigma(log.world, found.start);
  const Vector3d after = o.loose * attitude_sigma(log.world, {found.start.time, smoothed.x, smoothed.P});
  found.start.x.q_wb = smoothed.x.q_wb;
  set_attitude_sigma(log.world, found.start, after.cwiseMax(o.least_sigma).cwiseMin(before));
  set_boresight(found.start, log, options);
  return found;
}

// The start at the time `begin` of a body that is stationary until after the time of `found`.
Start carried_back(const Log& log, const FilterOptions& options, const Receiver& receiver, const FoundHeading& found,
                   double begin) {
  const StartOptions& o = options.behaviour.start;
  const double lapse = found.start.time - begin;
  const GyroBias bias = bias_before(log, options, found.start.time);
  const double turned = std::hypot(options.sensor.gyro.noise * std::sqrt(lapse), bias.sigma * lapse);
  const double heading = attitude_sigma(log.world, found.start).z();
  const std::optional<Rest> rest = rest_at(log, begin, o);
  Start start;
  set_known(start.x, options);
  start.time = begin;
  start.x.q_wb = carry_back(log, found.start.x.q_wb, begin, found.start.time, bias.value);
  if (rest) {
    const Quaterniond q_wn = local_level(log.world, receiver, begin);
    start.x.q_wb = q_wn * levelled(q_wn.conjugate() * start.x.q_wb, -rest->mean_force);
  }
  place_at_rest(log.world, start, receiver, o);
  const double tilt = rest ? o.tilt_sigma : o.unlevelled * o.tilt_sigma;
  set_attitude_sigma(log.world, start,
                     {tilt, tilt, std::min(std::hypot(heading, turned), hypothesis_sigma(o) * o.hypotheses)});
  set_boresight(start, log, options);
  return start;
}

}  // namespace

std::vector<Start> heading_hypotheses(const Log& log, const FilterOptions& options, const Receiver& receiver,
                                      double begin) {
  const StartOptions& o = options.behaviour.start;
  const std::optional<Rest> departing = departure_from(log, receiver, begin, o).before;
  std::vector<Start> hypotheses;
  for (int k = 0; k < o.hypotheses; ++k) {
    const double heading = k * spacing(o);
    hypotheses.push_back(departing ? still_start(log, options, receiver, *departing, heading)
                                   : start_on_the_move(log, options, receiver, begin, heading, hypothesis_sigma(o)));
  }
  return hypotheses;
}

FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, double begin) {
  const auto [leaves, departing] = departure_from(log, receiver, begin, options.behaviour.start);
  FoundHeading found = search_heading(log, options, heading_hypotheses(log, options, receiver, begin));
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
    return {
        found.start,
        fmt::format("the motion does not determine the heading at the start; {:.0f} deg ± {:.0f} is the most likely "
                    "one, and `initial: {{heading: … deg}}` states it",
                    heading / kDegree, sigma / kDegree)};
  }
  return {found.start,
          fmt::format("heading at the start {:.1f} deg ± {:.2f}, from the motion until t = {:.1f} s", heading / kDegree,
                      sigma / kDegree, found.until),
          found.until + options.behaviour.start.look_back};
}

}  // namespace piste
