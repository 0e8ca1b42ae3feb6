#pragma once
/// What the sensors said: as read (Recording), and as the filter takes it (Log).

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "piste/math/earth.h"

namespace piste {

// ---- As read: sensor clock, sensor axes, SI and radians. ----

/// One IMU file. Rows are rates and specific forces, or increments since the row before.
struct ImuRecording {
  std::string file;
  bool increments = false;
  std::vector<double> time;
  std::vector<Vector3d> gyro, accel;
  std::vector<Vector3d> magnetic;   ///< [µT], empty or one a row
  std::vector<double> temperature;  ///< [°C], empty or one a row
};

/// How a receiver came by a fix; kPrecise is a carrier-phase solution of any other kind, such as PPP.
enum class FixQuality : std::uint8_t { kUnknown, kSingle, kDifferential, kPrecise, kFloat, kFixed, kDeadReckoned };

/// Velocity of a fix. A sigma of down that is infinite: only the horizontal velocity was measured, down reads 0.
struct FixVelocity {
  Vector3d value, sigma;
  bool has_down() const { return std::isfinite(sigma.z()); }
};

/// One fix of a receiver's antenna; velocity and sigmas in local north-east-down.
struct GeodeticFix {
  double time = 0;
  Geodetic position;
  Vector3d sigma_position;
  std::optional<FixVelocity> velocity;
  FixQuality quality = FixQuality::kUnknown;
};

struct GnssRecording {
  std::string file;
  std::vector<GeodeticFix> fixes;
  std::size_t without_fix = 0;  ///< epochs of the file in which the receiver says that it has none
};

/// Attitude of a reference IMU's axes in local north-east-down: (roll, pitch, heading).
struct EulerFix {
  double time = 0;
  Vector3d angles, sigma;
};

struct AttitudeRecording {
  std::string file;
  std::vector<EulerFix> fixes;
  std::size_t not_valid = 0;  ///< epochs of the file whose attitude the reference itself does not trust
};

struct Recording {
  ImuRecording imu;
  std::vector<GnssRecording> gnss;
  std::vector<AttitudeRecording> attitude;
};

// ---- As the filter takes it: GPS time, body axes, world frame. ----

/// What a filled-in sample may be wrong by, as a random walk.
struct GapNoise {
  double gyro = 0;   ///< rad/s/sqrt(Hz)
  double accel = 0;  ///< m/s²/sqrt(Hz)
};

/// Rotation and velocity increments over (time − interval, time], body axes.
struct ImuSample {
  double time = 0, interval = 0;
  Vector3d dtheta = Vector3d::Zero(), dvel = Vector3d::Zero();
  std::uint8_t clipped_gyro = 0, clipped_accel = 0;  ///< bit i: axis i stood at the sensor's range
  std::optional<GapNoise> gap = {};                  ///< filled in: nothing was measured here
  bool at_rest = false;                              ///< the rest detector says that the body stands still
};

/// One fix of a receiver's antenna, in w; sigmas along w.
struct GnssFix {
  double time = 0;
  Vector3d position, sigma_position;
  std::optional<FixVelocity> velocity;
};

/// Attitude of the reference axes, R_wr, and the covariance [rad²] of its rotation-vector error in w.
struct AttitudeFix {
  double time = 0;
  Quaterniond q_wr;
  Matrix3d covariance;
};

/// Magnetic field, body axes, any unit.
struct MagneticSample {
  double time = 0;
  Vector3d field;
};

struct Interval {
  double start = 0, end = 0;
  bool contains(double t) const { return t >= start && t <= end; }
};

/// What conditioning counted; nothing is dropped without a count.
struct LogCounts {
  std::size_t imu_gaps = 0, imu_rejected = 0, imu_clipped = 0;
  std::vector<std::size_t> gnss_withheld, gnss_outside;  ///< a receiver each: in an outage; outside the IMU's span
  std::vector<std::size_t> attitude_outside;
  std::vector<std::size_t> gnss_without_fix, attitude_not_valid;  ///< a source each: of the whole file
};

/// Time-ordered, one clock. `gnss[i]` and `attitude[i]` are the fixes of source i.
struct Log {
  World world;
  std::vector<ImuSample> imu;
  std::vector<std::vector<GnssFix>> gnss;
  std::vector<std::vector<AttitudeFix>> attitude;
  std::vector<MagneticSample> magnetic;
  std::vector<Interval> rest;
  LogCounts counts;
};

}  // namespace piste
