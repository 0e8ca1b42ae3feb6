#pragma once
/// The configuration of `replay`, whole.

#include <filesystem>
#include <string>
#include <vector>

#include "piste/core/options.h"
#include "piste/io/imu_source.h"

namespace piste {

struct ReplayConfig {
  std::filesystem::path file;
  std::string echo;  ///< the file's text
  ImuSource imu;
  std::vector<LogFile> gnss, attitude;
  ConditioningOptions conditioning;
  /// As far as the configuration knows: `replay()` adds what the logs say. `estimate` holds only blocks
  /// that can be estimated: a bias or scale whose sigma is 0, and a drift without a process, are left out.
  FilterOptions filter;
  InitialHeading initial;
  SmootherKind smoother = SmootherKind::kRts;
  double attitude_rate = 10;  ///< Hz of attitude.csv
};

/// Reads and checks the configuration; of the data files only that they are there. Beyond the documented keys:
/// `rest: {sigma_velocity, sigma_rate, correlation_time, interval}`, `initial: {sigma, declination}`,
/// `magnetometer: {sigma, declination}` (updates by its heading), the start sigmas `priors: {boresight, lever_arm,
/// gnss_delay}`, `attitude_output: {rate}` of attitude.csv, and in an attitude source `boresight: {sigma,
/// correlation_time}`, of a mount that gives: the boresight is then a constant and a first-order Gauss-Markov process
/// about it. Throws ConfigError `FILE:LINE: …`.
ReplayConfig read_replay_config(const std::filesystem::path& file);
ReplayConfig read_replay_config(const Config& config);

/// Reads all logs of the configuration. Throws DataError `FILE:LINE: …`.
Recording read_recording(const ReplayConfig& config);

}  // namespace piste
