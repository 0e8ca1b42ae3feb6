#pragma once
/// Simulated sensors: the recordings that sensors would make of a true motion, and the errors that were added.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/sim/truth.h"

namespace piste {

/// Settings for the true errors of three axes of the same kind. A bias or scale that is not given is drawn from the
/// sensor's sigmas.
struct TriadTruth {
  std::optional<Vector3d> bias, scale;
  Vector3d bias_spread = Vector3d::Zero(),
           scale_spread = Vector3d::Zero();  ///< 1-sigma about the given values, drawn anew for each seed
  /// 1-sigma of the off-diagonal elements of M in measured = (1 + scale) (1 + M) true + …. If it is not given,
  /// they are drawn from the sensor's cross-axis errors. Accelerometers define the axes of the body: theirs are those
  /// below the diagonal.
  std::optional<double> misalignment;
  Vector3d warm_up = Vector3d::Zero();  ///< added at the start, fading as exp(−t / warm_up_time)
  double warm_up_time = 120;
  /// 1-sigma of the rounding of the signal's integral. The rows have the differences of this rounding ("blue" noise).
  double quantization = 0;
};

/// An IMU and how it is mounted.
struct ImuSetup {
  std::string name;                            ///< of its file and of its random streams
  std::filesystem::path sensor_file;           ///< from which `sensor` was read
  Quaterniond q_rb = Quaterniond::Identity();  ///< boresight against the plate r
  Vector3d p_rb_r = Vector3d::Zero();
  ImuSensor sensor;
  TriadTruth gyro, accel;
  double rate = 100;  ///< Hz of its own clock
  enum class Sampling { kMean, kInstant, kIncrements } sampling = Sampling::kMean;
  double clock_offset = 0, clock_drift = 0;  ///< gps time = t − offset − drift (t − first t)
  std::optional<Vector3d> magnetic_field;    ///< along north, east, down [µT]; if given, the rows have it
  /// Its errors: iron is drawn from its priors, noise and disturbance from their own sigmas.
  MagnetometerOptions magnetometer{.sigma = 0, .hard_iron = 0, .soft_iron = 0, .disturbance = {Vector3d::Zero(), 1}};
};

/// Statistics over the rows of one phase: the mean of in-run drift and warm-up; mean and root mean square of the true
/// signal.
struct PhaseDraw {
  std::size_t rows = 0;  ///< if 0, all else is 0
  Vector3d drift = Vector3d::Zero(), mean = Vector3d::Zero(), rms = Vector3d::Zero();
};

/// The errors that were drawn for one triad, for truth.json.
struct TriadDraw {
  Vector3d bias, scale;
  Matrix3d misalignment;
  Vector3d drift_first, drift_last, drift_mean, drift_rms;  ///< of the in-run drift
  PhaseDraw before, run, after;
  std::size_t clipped = 0;  ///< rows with an axis at ± range
};

/// The rows of a simulated IMU, with the truth. Row k has the time `recording.time[k]` on the IMU's clock, and
/// `gps_time[k]` in GPS time.
struct SimulatedImu {
  ImuRecording recording;
  std::vector<double> gps_time;
  std::vector<Vector3d> gyro_drift, accel_drift;  ///< of each row
  std::vector<MeanInertial> signal;               ///< rate and force of a perfect IMU, of each row
  TriadDraw gyro, accel;
  Matrix3d g_sensitivity = Matrix3d::Zero();  ///< of the gyroscopes [rad/s per m/s²]
  Vector3d hard_iron = Vector3d::Zero();      ///< [µT]
  Matrix3d soft_iron = Matrix3d::Zero();
  std::vector<Vector3d> magnetic_disturbance;  ///< of each row, north, east, down; empty without a magnetometer
};

/// The output of a magnetometer without errors: `field` (north, east, down) in the axes of the body.
Vector3d field_in_body(const Truth& body, double time, const Vector3d& field);

/// Simulates an IMU over the whole run: measured = (1 + scale) · (1 + M) true + G f + bias + drift + warm-up + noise,
/// limited to ± range. The white noise of a row has the sigma density / sqrt(dt). `plate` is the truth of r. The first
/// row ends one step after the start.
SimulatedImu simulate_imu(const Truth& plate, const ImuSetup& setup, std::uint64_t seed);

/// A GNSS receiver and its antenna. Noises are along local north, east, down.
struct GnssSetup {
  std::string name;
  Vector3d p_ra_r = Vector3d::Zero();
  double rate = 10;
  Vector3d position_noise = Vector3d::Constant(0.01);   ///< white
  std::optional<GaussMarkov> position_drift;            ///< coloured, added to the white
  Vector3d velocity_noise = Vector3d::Constant(0.03);   ///< white; 0 = the receiver gives no velocity
  double delay = 0;                                     ///< the position of a fix with time t is that of t − delay
  std::optional<double> velocity_delay = std::nullopt;  ///< of its velocity; nothing: it is `delay`

  double delay_of_velocity() const { return velocity_delay.value_or(delay); }
};

/// Simulates a receiver over the whole run. The sigmas of the fixes are those of the white and the coloured error
/// together.
GnssRecording simulate_gnss(const Truth& plate, const GnssSetup& setup, std::uint64_t seed);
/// The coloured error of each of those fixes, north, east, down. Empty if there is none.
std::vector<Vector3d> position_drift(const Truth& plate, const GnssSetup& setup, std::uint64_t seed);

/// A reference attitude, which is that of the plate's axes.
struct AttitudeSetup {
  std::string name;
  double rate = 10;
  Vector3d noise = Vector3d::Constant(1e-5);  ///< white, rotation vector in w
  std::optional<GaussMarkov> drift;           ///< coloured, added to the white
  double delay = 0;                           ///< a fix with time t is that of t − delay
};

/// Simulates a reference attitude over the whole run, in local north-east-down: R_wr measured = Exp(e) R_wr, with e the
/// sum of the white and the coloured error. The sigmas of the Euler angles follow from those of e.
AttitudeRecording simulate_attitude(const Truth& plate, const AttitudeSetup& setup, std::uint64_t seed);
/// The coloured error of each of those fixes, as a rotation vector in w. Empty if there is none.
std::vector<Vector3d> attitude_drift(const Truth& plate, const AttitudeSetup& setup, std::uint64_t seed);

}  // namespace piste
