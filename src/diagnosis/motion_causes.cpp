// Axes and clock as the cause: the motion of the log says how gyroscopes and accelerometers point, and when.

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "diagnosis/cause_support.h"
#include "piste/inspect/log_match.h"

namespace piste {
namespace {

// The log in the form of files, as the matching of logs takes it.
ImuRecording recorded_imu(const Log& log) {
  ImuRecording imu;
  imu.increments = true;
  for (const ImuSample& s : log.imu) {
    imu.time.push_back(s.time);
    imu.gyro.push_back(s.dtheta);
    imu.accel.push_back(s.dvel);
  }
  return imu;
}

GnssRecording recorded_gnss(const Log& log) {
  GnssRecording gnss;
  for (const GnssFix& f : log.gnss.front()) {
    GeodeticFix fix{.time = f.time,
                    .position = log.world.to_geodetic(f.position),
                    .sigma_position = f.sigma_position,
                    .velocity = f.velocity};
    if (fix.velocity) fix.velocity->value = log.world.rotation_wn(f.position).transpose() * fix.velocity->value;
    gnss.fixes.push_back(fix);
  }
  return gnss;
}

// The run after a change, with its start found anew.
TestedCause from_new_start(FilterInput changed, const Evidence& base, double end, const InitialHeading& heading,
                           const std::string& text) {
  if (!start_anew(changed, heading)) return {};
  return {lasting_gain(filter_again(changed.log, changed.options, changed.start, end), base), text, {}};
}

Cause turned(const Matrix3d& gyro, const Matrix3d& accel, const std::string& text, const InitialHeading& heading) {
  return [=](const FilterInput& input, const Evidence& base, double end) {
    FilterInput changed = input;
    for (ImuSample& s : changed.log.imu) {
      s.dtheta = (gyro * s.dtheta).eval();
      s.dvel = (accel * s.dvel).eval();
    }
    return from_new_start(std::move(changed), base, end, heading, text);
  };
}

Cause shifted(double ahead, const InitialHeading& heading) {
  return [=](const FilterInput& input, const Evidence& base, double end) {
    FilterInput changed = input;
    move_fixes(changed.log, [ahead](double) { return ahead; });
    return from_new_start(
        std::move(changed), base, end, heading,
        fmt::format("offset of the IMU's clock ({:+.2f} s more than the file's, as the motion has it)", ahead));
  };
}

}  // namespace

std::vector<Cause> motion_causes(const FilterInput& input, const InitialHeading& heading) {
  std::vector<Cause> causes;
  if (input.log.gnss.empty()) return causes;
  const GnssRecording gnss = recorded_gnss(input.log);
  const LogMatch found = match(recorded_imu(input.log), gnss, gnss_health(gnss));
  // What is less, the delay of the fixes can be.
  if (found.clock && std::abs(found.clock->offset) > kWideClock)
    causes.push_back(shifted(found.clock->offset, heading));
  if (!found.motion) return causes;
  const MotionMatch& motion = *found.motion;
  if (!motion.gyro_axes.isIdentity()) {
    causes.push_back(
        turned(motion.gyro_axes, Matrix3d::Identity(),
               fmt::format("axes of the gyroscopes ({} in those of the accelerometers)", axes_text(motion.gyro_axes)),
               heading));
  }
  if (!motion.mirrored && !motion.R_bs.isIdentity()) {
    causes.push_back(turned(motion.R_bs * motion.gyro_axes, motion.R_bs,
                            fmt::format("axes of the IMU (`{}` of the present ones)", motion.axes), heading));
  }
  return causes;
}

}  // namespace piste
