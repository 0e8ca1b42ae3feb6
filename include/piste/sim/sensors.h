#pragma once
/// What sensors would have said of a truth: recordings as files hold them, and the errors that were put in.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/sim/truth.h"

namespace piste {

/// True errors of three like axes. What is given is taken; what is not is drawn from the sensor's sigmas.
struct TriadTruth {
  std::optional<Vector3d> bias, scale;
  Vector3d bias_spread = Vector3d::Zero(), scale_spread = Vector3d::Zero();  ///< 1 sigma about what is given, per seed
  /// measured = (1 + scale) M true + …; M is 1 on the diagonal and N(0, misalignment) off it.
  double misalignment = 0;
  Vector3d warm_up = Vector3d::Zero();  ///< added at the start, fading as exp(−t / warm_up_time)
  double warm_up_time = 120;
  /// Rounding of the integral of the signal: its sigma, seen differenced in the rows ("blue" noise).
  double quantization = 0;
};

/// An IMU and how it is mounted.
struct ImuSetup {
  std::string name;                            ///< of the file, and of its random streams
  std::filesystem::path sensor_file;           ///< that `sensor` was read from
  Quaterniond q_rb = Quaterniond::Identity();  ///< boresight against the plate r
  Vector3d p_rb_r = Vector3d::Zero();
  ImuSensor sensor;
  TriadTruth gyro, accel;
  double rate = 100;  ///< Hz of its own clock
  enum class Sampling { kMean, kInstant, kIncrements } sampling = Sampling::kMean;
  double clock_offset = 0, clock_drift = 0;  ///< gps time = t − offset − drift (t − first t)
  std::optional<Vector3d> magnetic_field;    ///< in w [µT]; where given, the rows carry it
  double magnetic_noise = 0;                 ///< [µT] a row
};

/// Over the rows of one phase: the mean of in-run drift and warm-up, mean and root mean square of the true signal.
struct PhaseDraw {
  std::size_t rows = 0;  ///< without any the rest is 0
  Vector3d drift = Vector3d::Zero(), mean = Vector3d::Zero(), rms = Vector3d::Zero();
};

/// The errors that one triad got, for truth.json.
struct TriadDraw {
  Vector3d bias, scale;
  Matrix3d misalignment;
  Vector3d drift_first, drift_last, drift_mean, drift_rms;  ///< of the in-run drift
  PhaseDraw before, run, after;
  std::size_t clipped = 0;  ///< rows with an axis at ± range
};

/// An IMU's rows, and what is true of them. Row k is stamped `recording.time[k]`, and is of GPS time `gps_time[k]`.
struct SimulatedImu {
  ImuRecording recording;
  std::vector<double> gps_time;
  std::vector<Vector3d> gyro_drift, accel_drift;  ///< a row each
  std::vector<MeanInertial> signal;               ///< of a perfect IMU: rate and force, a row each
  TriadDraw gyro, accel;
};

/// Rows of an IMU over the whole run. measured = (1 + scale) · M true + bias + drift + warm-up + noise, then held
/// within ± range; white noise of a row has density / sqrt(dt). `plate` is the truth of r. The first row ends one step
/// after the start.
SimulatedImu simulate_imu(const Truth& plate, const ImuSetup& setup, std::uint64_t seed);

/// A receiver and its antenna. Sigmas are of local north, east, down.
struct GnssSetup {
  std::string name;
  Vector3d p_ra_r = Vector3d::Zero();
  double rate = 10;
  Vector3d position_noise = Vector3d::Constant(0.01);  ///< white
  std::optional<GaussMarkov> position_drift;           ///< coloured, added to the white
  Vector3d velocity_noise = Vector3d::Constant(0.03);  ///< white; 0 = the receiver gives no velocity
  double delay = 0;                                    ///< a fix stamped t is of t − delay
};

/// Fixes over the whole run; their sigma columns are the total of white and coloured.
GnssRecording simulate_gnss(const Truth& plate, const GnssSetup& setup, std::uint64_t seed);
/// The coloured part of the error of each of those fixes, north, east, down; empty where there is none.
std::vector<Vector3d> position_drift(const Truth& plate, const GnssSetup& setup, std::uint64_t seed);

/// A reference attitude: of the plate's axes.
struct AttitudeSetup {
  std::string name;
  double rate = 10;
  Vector3d noise = Vector3d::Constant(1e-5);  ///< white, rotation vector in w
  std::optional<GaussMarkov> drift;           ///< coloured, added to the white
};

/// Attitude in local north-east-down over the whole run: R_wr measured = Exp(e) R_wr with e the sum of both errors.
/// Sigmas of the Euler angles are those of e carried through.
AttitudeRecording simulate_attitude(const Truth& plate, const AttitudeSetup& setup, std::uint64_t seed);
/// The coloured part of the error of each of those fixes, rotation vector in w; empty where there is none.
std::vector<Vector3d> attitude_drift(const Truth& plate, const AttitudeSetup& setup, std::uint64_t seed);

}  // namespace piste
