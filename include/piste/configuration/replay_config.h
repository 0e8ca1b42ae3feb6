#pragma once
/// Reads the configuration of `replay`, and the logs that it names.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "piste/configuration/imu_source.h"
#include "piste/core/options.h"
#include "piste/io/marks.h"
#include "piste/io/solution_io.h"

namespace piste {

/// Rows a second of the files that a replay writes [Hz]; 0: one at every epoch of the IMU.
struct OutputRates {
  double navigation = 0;  ///< of filtered.csv and smoothed.csv
  double biases = 10;     ///< of biases.csv and biases_smoothed.csv
  double attitude = 10;   ///< of attitude.csv
};

/// A named point of the body, with axes of its own.
struct OutputPoint {
  std::string name;
  Vector3d lever_arm = Vector3d::Zero();       ///< p_bp_b, from the IMU to it, in b
  Quaterniond q_bp = Quaterniond::Identity();  ///< turns components along its axes into b
};

/// What the files of a replay have besides the usual.
struct OutputOptions {
  RowExtras columns;                     ///< further columns of filtered.csv and smoothed.csv; without week and motion
  std::vector<OutputPoint> points = {};  ///< `smoothed_NAME.csv` of each
  bool covariance = false;               ///< `covariance_smoothed.csv`
  std::optional<int> week = std::nullopt;  ///< GPS week that the user states

  /// The point of that name; null if there is none.
  const OutputPoint* point(std::string_view name) const;
};

/// A file of marks, such as the shutter of a camera.
struct EventSource {
  MarkFile marks;
  double offset = 0, drift = 0;  ///< of their clock: instant = t − offset − drift · (t − first t) + delay
  double delay = 0;              ///< from the mark to what it marks [s]
  bool find_delay = false;       ///< the delay is found from the places of the marks
  std::string at = {};           ///< name of the point, or empty: the IMU
  bool metashape = false, pix4d = false;  ///< `events_metashape.txt` and `events_pix4d.txt` have them
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
  OutputOptions output = {};
  std::vector<EventSource> events = {};

  /// Whether outputs need the whole covariances of rows, so that rows are not streamed and the history is kept.
  bool needs_history() const;
};

/// Reads and checks the configuration. Of the data files it only checks that they are there. The keys are
/// in docs/keys.md. Throws ConfigError
/// `FILE:LINE: …`.
ReplayConfig read_replay_config(const std::filesystem::path& file);
ReplayConfig read_replay_config(const Config& config);

/// Reads all logs that the configuration names. Throws DataError `FILE:LINE: …`.
Recording read_recording(const ReplayConfig& config);

}  // namespace piste
