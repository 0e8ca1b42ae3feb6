#pragma once
/// Reads the configuration of `replay`, and the logs that it names.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "piste/configuration/imu_source.h"
#include "piste/core/options.h"

namespace piste {

/// Rows a second of the files that a replay writes [Hz]; 0: one at every epoch of the IMU.
struct OutputRates {
  double navigation = 0;  ///< of filtered.csv and smoothed.csv
  double biases = 10;     ///< of biases.csv and biases_smoothed.csv
  double attitude = 10;   ///< of attitude.csv
};

/// The configuration.
struct ReplayConfig {
  std::filesystem::path file;
  std::string echo;  ///< the file's text
  ImuSource imu;
  std::vector<ImuSource> further = {};  ///< of several IMUs: all but the first
  std::vector<LogFile> gnss, attitude;
  std::optional<LogFile> odometer = std::nullopt, barometer = std::nullopt, heading = std::nullopt;
  ConditioningOptions conditioning;
  /// The filter's options that the configuration determines; `replay()` adds the options that the logs determine.
  /// `estimate` has only blocks that can be estimated: a bias or scale whose sigma is 0 is left out, and a drift
  /// without a process too.
  FilterOptions filter;
  InitialHeading initial;
  SmootherKind smoother = SmootherKind::kRts;
  BatchOptions batch;
  OutputRates rates;
};

/// Reads and checks the configuration. Of the data files it only checks that they are there. The keys are
/// in docs/keys.md. Throws ConfigError
/// `FILE:LINE: …`.
ReplayConfig read_replay_config(const std::filesystem::path& file);
ReplayConfig read_replay_config(const Config& config);

/// Reads all logs that the configuration names. Throws DataError `FILE:LINE: …`.
Recording read_recording(const ReplayConfig& config);

}  // namespace piste
