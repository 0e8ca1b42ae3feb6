#pragma once
/// The result of an inspection: what is known of each log and of each pair of logs, what looks wrong, and a
/// configuration that replays them.

#include <optional>
#include <string>
#include <vector>

#include "piste/columns/log_guess.h"
#include "piste/core/options.h"
#include "piste/inspect/attitude_match.h"
#include "piste/inspect/gnss_health.h"
#include "piste/inspect/imu_health.h"
#include "piste/inspect/log_match.h"
#include "piste/inspect/suspicion.h"
#include "piste/inspect/vehicle_guess.h"

namespace piste {

/// 1-sigma of each axis of a lever arm where one housing has IMU and antenna, as in a phone or a logger. [m]
constexpr double kHousing = 0.15;

/// What says that a receiver has a slow error: the motion; that it states more than the innovations show, which do not
/// see what moves fixes and track together; or that rounding makes its heights stand still, which then have such an
/// error alone.
enum class DriftBy { kMotion, kClaim, kRounding };

/// What the filter itself tells of an IMU beside a receiver (experiment/calibration.h).
struct Calibration {
  Vector3d lever_arm, lever_arm_sigma;       ///< p_ba_b [m]
  double clock_offset = 0, clock_sigma = 0;  ///< of the IMU (ImuConditioning) [s]
  double clock_drift = 0;                    ///< likewise, from its first row on; a ratio
  double clock_drift_sigma = 0;              ///< 0: the log does not tell it
  /// By how much the receiver's velocities come late against the IMU's clock with `clock_offset` [s]. The sigma does
  /// not contain that of the clock; 0: they are taken as the log has them.
  double velocity_delay = 0, velocity_delay_sigma = 0;
  bool velocities_contradict = false;                 ///< the positions, and are not used
  ImuSensor sensor;                                   ///< with the noise to be expected from the motion
  SigmaScales sigma_scales = {};                      ///< of the receiver, likewise
  std::optional<PositionDrift> drift = std::nullopt;  ///< the slow error of its positions, if there is one
  DriftBy drift_by = DriftBy::kMotion;                ///< what says so
  std::size_t used = 0, rejected = 0;                 ///< GNSS innovations of the filter that told it
  double likelihood = 0;                              ///< over the whole log: logarithm of that of a fix
  double likelihood_of_positions = 0;                 ///< likewise, of a position
  bool in_housing = false;                            ///< whether IMU and antenna are taken to be in one housing

  /// Whether the filter fits the logs: it rejected less than a tenth.
  bool fits() const { return rejected < (used + rejected) / 10; }
  /// Whether the motion tells the lever arm, so that it is better known than that an antenna is near by.
  bool tells_arm() const {
    constexpr double kTellingSigma = 0.5;  // m
    return fits() && lever_arm_sigma.maxCoeff() < kTellingSigma;
  }
  /// Why a configuration does not have the lever arm that was found, in a sentence; nothing if the motion tells it.
  std::string why_no_arm() const;
};

/// The clock of a phone or logger against GPS time, from the two times that its receiver's log gives for each fix: GPS
/// time = t − offset − drift (t − since), where t is within `span`. The times since power-up are those of arrival, so
/// the offset contains the least latency of the receiver, of several to hundreds of milliseconds.
struct ReceiverClock {
  double offset = 0, drift = 0, since = 0;
  double scatter = 0;  ///< 1-sigma of a pair about the line, without outliers [s]
  Interval span;
  double gps_time(double t) const { return t - offset - drift * (t - since); }
};

/// Fits that line to pairs of times: robustly, as single fixes are logged late. Nothing if there are fewer than ten.
std::optional<ReceiverClock> fit_clock(const std::vector<double>& logger, const std::vector<double>& gps);

/// One file and all that is known of it.
struct InspectedLog {
  LogFile log;
  std::optional<LogGuess> guess;  ///< nothing if it is not a log of a known format
  RowFaults faults;
  ImuRecording imu;  ///< of these three only that of the guessed kind is filled
  GnssRecording gnss;
  AttitudeRecording attitude;
  std::optional<ImuHealth> imu_health;
  std::optional<GnssHealth> gnss_health;
  std::optional<Sampling> attitude_sampling;
  std::optional<Calibration> calibration;  ///< of the first IMU beside a receiver, if the filter could run
  /// Of a receiver whose log has two times: the clock of what logged it.
  std::optional<ReceiverClock> clock = {};
  /// What a receiver states for all of its velocities, which are far better than that [m/s]; 0: nothing of that kind.
  double coarse_velocity_sigma = 0;
  std::string left_out = {};  ///< why a configuration does not use it; empty: it does

  bool is(LogKind kind) const { return guess && guess->kind == kind; }
  /// What `repair` did, in words.
  std::string repaired() const;
};

/// The comparison of an IMU with a receiver, which are indices into Inspection::logs.
struct InspectedMatch {
  std::size_t imu, gnss;
  LogMatch match;
};

/// The comparison of the first IMU with an attitude log, which are indices into Inspection::logs.
struct InspectedAttitude {
  std::size_t imu, attitude;
  AttitudeMatch match;
};

struct Inspection {
  std::vector<InspectedLog> logs;
  std::vector<InspectedMatch> matches;
  std::vector<InspectedAttitude> attitudes;
  std::vector<Suspicion> suspicions;  ///< the worst first
  VehicleGuess vehicle = {};          ///< of the first IMU with the first receiver

  /// Index of the first log of a kind, or nothing.
  std::optional<std::size_t> first(LogKind kind) const;
  /// The clock of the first IMU, if a receiver's log tells it: both then count since power-up.
  const ReceiverClock* imu_clock() const;
  /// The match of the first IMU with the first receiver, or null.
  const LogMatch* first_match() const;
  /// The comparison of the first IMU with this attitude log, or null.
  const AttitudeMatch* attitude_match(const InspectedLog& attitude) const;
  /// The calibration of the first IMU with the first receiver, or null if there is none or it does not fit.
  const Calibration* calibration() const;
};

/// Sorts suspicions, the worst first, and removes repetitions. Those of one kind stay in their order.
void rank(std::vector<Suspicion>& suspicions);

/// Guesses the errors of a sensor from its log at rest: the noise is measured; bias, drift and scale are those that
/// sensors of such noise usually have; the range is that of clipped samples, if there are any.
ImuSensor guess_sensor(const ImuHealth& health, const std::string& name);

/// The sensor of the first IMU: with the noise that is likeliest in motion, or else with that at rest.
/// @pre there is an IMU
ImuSensor guess_sensor(const Inspection& inspection);

/// Guesses axes and clock of the first IMU from the motion; without motion, the axes from gravity.
ImuConditioning guess_conditioning(const Inspection& inspection);

/// The priors that a replay of the same logs is told after a calibration: loose, as it sees the same motion again.
Priors priors_after(const Calibration& found, Priors priors = {});

/// Whether ready_config() has a receiver's velocities used.
bool uses_velocities(const InspectedLog& receiver);

/// The `velocity_delay` [s] that ready_config() writes for a receiver; nothing where it writes none.
std::optional<double> written_velocity_delay(const Inspection& inspection, const InspectedLog& receiver);

/// Says of velocities that come late what ready_config() has of them, so that the advice and what is written are one.
void advise_as_written(Inspection& inspection);

/// The text of a configuration of `replay` for the first IMU and all receivers and attitudes that are not left out. Its
/// paths are relative to `folder`, where it and the sensor file `sensor_file` will be. Nothing if there is no IMU or no
/// receiver.
std::optional<std::string> ready_config(const Inspection& inspection, const std::string& folder,
                                        const std::string& sensor_file);

}  // namespace piste
