#include "start/start_rest.h"

#include <algorithm>
#include <cmath>

#include "core/time_search.h"

namespace piste {

Rest average(const Log& log, const Interval& interval) {
  Rest rest{interval, Vector3d::Zero(), Vector3d::Zero()};
  double time = 0;
  for (const ImuSample& s : range(log.imu, interval.start, interval.end)) {
    rest.mean_rate += s.dtheta;
    rest.mean_force += s.dvel;
    time += s.interval;
  }
  rest.mean_rate /= time;
  rest.mean_force /= time;
  return rest;
}

GyroBias bias_before(const Log& log, const FilterOptions& options, double t) {
  for (auto rest = log.rest.rbegin(); rest != log.rest.rend(); ++rest) {
    if (rest->start > t - options.behaviour.start.bias_rest) continue;
    const Interval known{rest->start, std::min(rest->end, t)};
    return {average(log, known).mean_rate, options.behaviour.rest.sigma_rate / std::sqrt(known.end - known.start)};
  }
  return {Vector3d::Zero(), options.sensor.gyro.bias};
}

std::optional<Rest> rest_at(const Log& log, double t, const StartOptions& options) {
  for (const Interval& r : log.rest) {
    if (r.start > t + options.rest_begins || r.end <= t + options.rest_lasts) continue;
    return average(log, {r.start, std::min(r.end, r.start + options.longest_rest)});
  }
  return std::nullopt;
}

}  // namespace piste
