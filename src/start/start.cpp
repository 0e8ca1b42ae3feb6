#include "piste/start/start.h"

#include "piste/core/error.h"
#include "start/heading_search.h"
#include "start/start_heading.h"
#include "start/start_motion.h"
#include "start/start_place.h"
#include "start/start_rest.h"
#include "start/vehicle_mounting.h"

namespace piste {
namespace {

// Constraints of the vehicle are not used: its mounting is not known yet.
FoundStart find_start_of_body(const Log& log, const FilterOptions& options, const InitialHeading& heading) {
  if (log.imu.empty()) throw DataError("start", "the log holds no IMU sample");
  const StartOptions& o = options.behaviour.start;
  const Receiver receiver = first_receiver(log, options);
  const auto [begin, rest] = beginning(log, receiver, o);
  Start start;
  set_known(start.x, options);
  start.time = begin;
  using Source = InitialHeading::Source;
  if (heading.source == Source::kAuto) return start_from_motion(log, options, receiver, start.time);

  const Pointing pointing = heading.source == Source::kAttitude
                                ? point_by_reference(log, options, receiver, start, rest)
                                : point_by_heading(log, options, receiver, start, heading, rest);
  if (rest) {
    start.x.q_wb = pointing.q_wb;
    place_at_rest(log.world, start, receiver, o);
  } else {
    const Quaterniond level = local_level(log.world, receiver, start.time).conjugate();
    start = start_on_the_move(log, options, receiver, start.time, to_euler(level * pointing.q_wb).z(), pointing.sigma);
    start.x.q_wb = pointing.q_wb;
  }
  const double tilt = rest ? o.tilt_sigma : o.unlevelled * o.tilt_sigma;
  set_attitude_sigma(log.world, start, {tilt, tilt, pointing.sigma});
  set_boresight(start, log, options);
  return {start, pointing.how};
}

}  // namespace

Start without_alignment(const World& world, const FoundStart& found) {
  constexpr double kTilt = 0.5;  // rad: uninformative
  Start start = found.start;
  if (found.aligned) set_attitude_sigma(world, start, {kTilt, kTilt, kUnknownHeading});
  return start;
}

FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading) {
  if (!options.vehicle) return find_start_of_body(log, options, heading);
  FoundStart found = find_start_of_body(log, without_vehicle(options), heading);
  set_known(found.start.x, options);
  return found;
}

}  // namespace piste
