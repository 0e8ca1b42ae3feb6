// The words for faults between an attitude log and an IMU.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string_view>

#include "adding_to.h"
#include "math/words.h"
#include "piste/inspect/attitude_match.h"
#include "piste/inspect/log_match.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// A rotation by a multiple of 90 degrees, such as `90 deg about down`. Other rotations of the cube are given by their
// axes alone.
std::string turn_text(const Matrix3d& R) {
  static constexpr std::array<std::string_view, 3> kNames{"forward", "right", "down"};
  const Eigen::AngleAxisd turn(R);
  const Vector3d& axis = turn.axis();
  Eigen::Index main = 0;
  if (axis.cwiseAbs().maxCoeff(&main) < 0.99) {
    return fmt::format("about more than one axis, {:.0f} deg in all", turn.angle() / kDegree);
  }
  const double angle = turn.angle() / kDegree * (axis(main) > 0 ? 1 : -1);
  return fmt::format("by {:.0f} deg about {}", std::abs(angle) > 170 ? 180.0 : angle,
                     kNames[static_cast<std::size_t>(main)]);
}

}  // namespace

std::string attitude_delay_text(const AttitudeFit& fit, double imu_offset) {
  return fmt::format("delay: {} s", with_decimals(attitude_delay(fit, imu_offset), 4));
}

std::vector<Suspicion> suspicions(const AttitudeMatch& m, const Matrix3d& axes, const std::string& imu_file,
                                  const std::string& attitude_file) {
  std::vector<Suspicion> found;
  const auto add = adding_to(found, attitude_file);
  const std::string spans = fmt::format("the IMU covers {:.3f} to {:.3f} s, the attitude {:.3f} to {:.3f} s",
                                        m.imu.start, m.imu.end, m.attitude.start, m.attitude.end);
  if (!m.fit) {
    if (m.imu.end > m.imu.start && !(m.overlap > 0)) {
      add(LogFault::kNoOverlap, fmt::format("has no time in common with {}: {}; {}", imu_file, spans, m.why_not),
          "are they of the same run?");
    }
    return found;
  }
  const AttitudeFit& fit = *m.fit;
  if (m.is_late()) {
    const double delay = attitude_delay(fit, 0);
    const std::string by = fmt::format("its times are {} against {} (+- {}; the rates correlate by {:.3f})",
                                       delay_text(delay), imu_file, time_text(fit.sigma_offset), m.correlation);
    add(m.overlap > 0 ? LogFault::kAttitudeClock : LogFault::kNoOverlap,
        m.overlap > 0 ? by : fmt::format("the logs have no time in common: {}; {}", spans, by),
        fmt::format("{} {} {} its times", delay > 0 ? "subtract" : "add", time_text(std::abs(delay)),
                    delay > 0 ? "from" : "to"));
  }
  if (!fit.axes.isApprox(axes)) {
    add(LogFault::kAttitudeAxes,
        fmt::format("its axes forward, right, down are {} of {}, where {} are expected: turned {}", axes_text(fit.axes),
                    imu_file, axes_text(axes), turn_text(axes * fit.axes.transpose())),
        fmt::format("if the attitude is of the vehicle, `axes: {}` of the IMU; else replay's `boresight` takes it up",
                    axes_text(fit.axes)));
  }
  return found;
}

}  // namespace piste
