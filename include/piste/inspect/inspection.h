#pragma once
/// All that some logs say of themselves and of one another, and a configuration that would replay them.

#include <optional>
#include <string>
#include <vector>

#include "piste/core/options.h"
#include "piste/inspect/gnss_health.h"
#include "piste/inspect/imu_health.h"
#include "piste/inspect/log_guess.h"
#include "piste/inspect/log_match.h"
#include "piste/inspect/suspicion.h"

namespace piste {

/// Where the antenna sits, as the motion tells it.
struct LeverArmGuess {
  Vector3d value, sigma;               ///< b → antenna [m]
  std::size_t used = 0, rejected = 0;  ///< innovations of GNSS
};

/// One file, as far as it could be read.
struct InspectedLog {
  LogFile log;
  std::optional<LogGuess> guess;  ///< none where it is no log that we know
  RowFaults faults;
  ImuRecording imu;  ///< of these three the one that the guess says
  GnssRecording gnss;
  AttitudeRecording attitude;
  std::optional<ImuHealth> imu_health;
  std::optional<GnssHealth> gnss_health;
  std::optional<Sampling> attitude_sampling;
  std::optional<LeverArmGuess> lever_arm;  ///< of a receiver against the first IMU, where the filter could run

  bool is(LogKind kind) const { return guess && guess->kind == kind; }
};

/// An IMU beside a receiver; indices into Inspection::logs.
struct InspectedMatch {
  std::size_t imu, gnss;
  LogMatch match;
};

struct Inspection {
  std::vector<InspectedLog> logs;
  std::vector<InspectedMatch> matches;
  std::vector<Suspicion> suspicions;  ///< the worst first

  /// Index of the first log of a kind, none where there is none.
  std::optional<std::size_t> first(LogKind kind) const;
  /// That of the first IMU with the first receiver, null where there is none.
  const LogMatch* first_match() const;
};

/// The worst first, those of one kind in the order given; what is said twice of a file is said once.
void rank(std::vector<Suspicion>& suspicions);

/// A sensor's errors as far as its log at rest shows them: noise as measured; bias, drift and scale such as sensors of
/// that noise have; the range where the log shows one.
ImuSensor guess_sensor(const ImuHealth& health, const std::string& name);

/// How the first IMU is to be conditioned: axes and clock from the motion, else from gravity.
ImuConditioning guess_conditioning(const Inspection& inspection);

/// A configuration of `replay` for the first IMU and all receivers and attitudes, with paths relative to `folder`,
/// where it and the sensor file `sensor_file` are to stand; none without an IMU and a receiver.
std::optional<std::string> ready_config(const Inspection& inspection, const std::string& folder,
                                        const std::string& sensor_file);

}  // namespace piste
