#include "piste/solve/start.h"

#include "piste/core/error.h"
#include "start_heading.h"
#include "start_motion.h"
#include "start_place.h"
#include "start_rest.h"

namespace piste {

FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading) {
  if (log.imu.empty()) throw DataError("start", "the log holds no IMU sample");
  const Receiver receiver = first_receiver(log, options);
  constexpr double kLongestRest = 10;  // s of rest that are used
  Start start;
  set_delays(start.x, options);
  start.time = log.imu.front().time - log.imu.front().interval;
  std::optional<Rest> rest = rest_at(log, start.time, kLongestRest);
  if (!rest && receiver.fixes.front().time > start.time) {
    start.time = receiver.fixes.front().time;  // the body already moves: the run begins at the first fix
    rest = rest_at(log, start.time, kLongestRest);
  }
  using Source = InitialHeading::Source;
  if (heading.source == Source::kAuto) return start_from_motion(log, options, receiver, start, rest);

  const Pointing pointing = heading.source == Source::kAttitude
                                ? point_by_reference(log, options, start, rest)
                                : point_by_heading(log, options, receiver, start, heading, rest);
  start.x.q_wb = pointing.q_wb;
  place(start, receiver, rest.has_value());
  const double tilt = rest ? kTiltSigma : 5 * kTiltSigma;
  set_attitude_sigma(start, {tilt, tilt, pointing.sigma});
  set_boresight(start, log, options);
  return {start, pointing.how};
}

}  // namespace piste
