#pragma once
/// The result of an inspection: the properties of each log and of each pair of logs, their faults, and a configuration
/// that replays them.

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

/// 1-sigma of each axis of a lever arm if IMU and antenna share a housing, as in a phone or a logger. [m]
constexpr double kHousing = 0.15;

/// The evidence for a slow error of a receiver's positions. kMotion: the innovations. kClaim: the receiver states
/// larger sigmas than the innovations show; innovations do not observe an error that moves fixes and track together.
/// kRounding: rounding makes heights constant, so that only heights have such an error.
enum class DriftBy { kMotion, kClaim, kRounding };

/// What the filter estimates of an IMU with the fixes of a receiver (search/calibration.h).
struct Calibration {
  Vector3d lever_arm, lever_arm_sigma;       ///< p_ba_b [m]
  double clock_offset = 0, clock_sigma = 0;  ///< of the IMU (ImuConditioning) [s]
  double clock_spread = 0;       ///< 1-sigma of the offsets that were about as likely; it is in clock_sigma [s]
  double clock_drift = 0;        ///< of the IMU's clock, from its first row on; a ratio
  double clock_drift_sigma = 0;  ///< 1-sigma of clock_drift; 0: the log does not determine it
  /// By how much the receiver's velocities come late against the IMU's clock with `clock_offset` [s]. The sigma does
  /// not contain the sigma of the clock. A sigma of 0: velocities are used with the times in the log.
  double velocity_delay = 0, velocity_delay_sigma = 0;
  double velocity_averaging = 0;                      ///< the time over which its velocities are means [s]
  bool velocities_contradict = false;                 ///< velocities contradict the positions and are not used
  ImuSensor sensor;                                   ///< with the noise that is expected in motion
  SigmaScales sigma_scales = {};                      ///< of the receiver, as expected in motion
  std::optional<PositionDrift> drift = std::nullopt;  ///< the slow error of its positions, if there is one
  DriftBy drift_by = DriftBy::kMotion;                ///< the evidence for `drift`
  std::optional<GaussMarkov> sway = std::nullopt;     ///< of its antenna on the body
  std::size_t used = 0, rejected = 0;                 ///< GNSS innovations of the filter that estimated this
  double likelihood = 0;                              ///< log-likelihood per fix, over the whole log
  double likelihood_of_positions = 0;                 ///< log-likelihood per position, over the whole log
  bool in_housing = false;                            ///< whether IMU and antenna are assumed to share a housing
  bool instantaneous = false;                         ///< whether the IMU's rows are instants (ImuConditioning)

  /// Whether the filter fits the logs: it rejected less than a tenth of the innovations.
  bool fits() const { return rejected < (used + rejected) / 10; }
  /// Whether the motion determines the lever arm better than the assumption that the antenna is near by.
  bool tells_arm() const {
    constexpr double kTellingSigma = 0.5;  // m
    return fits() && lever_arm_sigma.maxCoeff() < kTellingSigma;
  }
  /// Why a configuration omits the estimated lever arm, in a sentence; empty if the motion determines the arm.
  std::string why_no_arm() const;
};

/// The clock of a phone or logger against GPS time, from the two times that its receiver's log gives for each fix: GPS
/// time = t − offset − drift (t − since), where t is within `span`. The times since power-up are times of arrival. So
/// the offset contains the least latency of the receiver, from several to hundreds of milliseconds.
struct ReceiverClock {
  double offset = 0, drift = 0, since = 0;
  double scatter = 0;  ///< 1-sigma of a pair about the line, without outliers [s]
  Interval span;
  double gps_time(double t) const { return t - offset - drift * (t - since); }
};

/// Fits that line to pairs of times, robustly, as single fixes are logged late. Nothing if there are fewer than ten
/// pairs.
std::optional<ReceiverClock> fit_clock(const std::vector<double>& logger, const std::vector<double>& gps);

/// One file and its properties.
struct InspectedLog {
  LogFile log;
  std::optional<LogGuess> guess;  ///< nothing if it is not a log of a known format
  RowFaults faults;
  ImuRecording imu;  ///< of `imu`, `gnss` and `attitude` only the guessed kind is filled
  GnssRecording gnss;
  AttitudeRecording attitude;
  std::optional<ImuHealth> imu_health;
  std::optional<GnssHealth> gnss_health;
  std::optional<Sampling> attitude_sampling;
  std::optional<Calibration> calibration;  ///< of the first IMU with this receiver, if the filter could run
  /// Of a receiver whose log has two times: the clock of the logging device.
  std::optional<ReceiverClock> clock = {};
  /// The one sigma that a receiver states for all of its velocities, if they are far better than that [m/s]; 0: none.
  double coarse_velocity_sigma = 0;
  bool velocities_refuted = false;  ///< its velocities contradict its positions, and are not used
  std::string left_out = {};        ///< why a configuration does not use the log; empty: it does

  bool is(LogKind kind) const { return guess && guess->kind == kind; }
  /// What `repair` did, in words.
  std::string repaired() const;
};

/// The comparison of an IMU with a receiver. Both are indices into Inspection::logs.
struct InspectedMatch {
  std::size_t imu, gnss;
  LogMatch match;
};

/// The comparison of the first IMU with an attitude log. Both are indices into Inspection::logs.
struct InspectedAttitude {
  std::size_t imu, attitude;
  AttitudeMatch match;
};

/// A replay of what an inspection writes (search/rounds.h).
struct InspectedRound {
  std::string verdict;     ///< in one line
  std::string taken = {};  ///< the cause that the configuration then took; empty: none
  double gain = 0;         ///< of the log-likelihood of the whole log by that
};

/// One reading of the logs: the keys of a configuration that state it, and the log-likelihood of the innovations of a
/// replay with it.
struct InspectedReading {
  std::string keys;
  double ln_p = 0;
};

/// A question that the logs leave open (search/readings.h).
struct InspectedDoubt {
  std::string what;                             ///< the question, such as `in which unit the rates are`
  std::string key;                              ///< the key of a configuration that answers it
  std::vector<InspectedReading> readings = {};  ///< the first is in the configuration
  /// The readings with what they are less likely than the first, in words.
  std::string readings_text() const;
};

struct Inspection {
  std::vector<InspectedLog> logs;
  std::vector<InspectedMatch> matches;
  std::vector<InspectedAttitude> attitudes;
  std::vector<Suspicion> suspicions;  ///< the worst first
  VehicleGuess vehicle = {};          ///< of the first IMU with the first receiver
  std::vector<InspectedRound> rounds = {};
  std::vector<InspectedDoubt> doubts = {};
  bool any_heading = false;  ///< the body does not leave its place, so that no heading is found
  /// The axes of the first IMU (ImuConditioning::R_bs), if a replay of the whole log takes other ones than the motion
  /// of its windows.
  std::optional<Matrix3d> axes = std::nullopt;

  /// Index of the first log of a kind, or nothing.
  std::optional<std::size_t> first(LogKind kind) const;
  /// The clock of the first IMU if a receiver's log states it: both logs then count time since power-up. Else null.
  const ReceiverClock* imu_clock() const;
  /// The match of the first IMU with the first receiver, or null.
  const LogMatch* first_match() const;
  /// The comparison of the first IMU with this attitude log, or null.
  const AttitudeMatch* attitude_match(const InspectedLog& attitude) const;
  /// The calibration of the first IMU with the first receiver, or null if there is none or it does not fit.
  const Calibration* calibration() const;
};

/// Sorts suspicions, the worst first, and removes repetitions. Suspicions of one kind stay in their order.
void rank(std::vector<Suspicion>& suspicions);

/// Guesses the errors of a sensor from its log at rest. The noise is measured. Bias, drift and scale are usual values
/// for sensors of such noise. The range is the limit of clipped samples, if there are any.
ImuSensor guess_sensor(const ImuHealth& health, const std::string& name);

/// The sensor of the first IMU: with the maximum-likelihood noise in motion, or else with the noise at rest.
/// @pre there is an IMU
ImuSensor guess_sensor(const Inspection& inspection);

/// Guesses axes and clock of the first IMU from the motion; without motion, the axes from gravity.
ImuConditioning guess_conditioning(const Inspection& inspection);

/// The priors for a replay of the same logs after a calibration. They are loose, because the replay uses the same
/// motion again.
Priors priors_after(const Calibration& found, Priors priors = {});

/// Whether ready_config() uses a receiver's velocities.
bool uses_velocities(const InspectedLog& receiver);

/// The `velocity_delay` [s] that ready_config() writes for a receiver; nothing where it writes none.
std::optional<double> written_velocity_delay(const Inspection& inspection, const InspectedLog& receiver);

/// Makes the advice on late velocities agree with the `velocity_delay` that ready_config() writes.
void advise_as_written(Inspection& inspection);

/// The text of a configuration of `replay` for the first IMU and all receivers and attitude logs that are not left out.
/// Its paths are relative to `folder`, which will hold it and the sensor file `sensor_file`. Nothing if there is no IMU
/// or no receiver.
std::optional<std::string> ready_config(const Inspection& inspection, const std::string& folder,
                                        const std::string& sensor_file);

}  // namespace piste
