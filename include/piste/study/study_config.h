#pragma once
/// Reads the configuration of `study`, which describes a campaign.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "piste/align/align_config.h"
#include "piste/core/aligned.h"
#include "piste/core/options.h"
#include "piste/io/log_io.h"
#include "piste/study/article.h"

namespace piste {

/// One run: a reference IMU, its receiver, and the IMUs that are studied, all on one plate.
struct RunConfig {
  std::string name, activity;
  MountedImu reference;
  struct Receiver {
    LogFile log;
    GnssOptions options;  ///< the lever arm is from r to the antenna, in r
  };
  std::optional<Receiver> gnss;
  std::optional<Phases> phases;  ///< nothing: detected in the signals
  std::vector<MountedImu> mems;
  std::optional<std::filesystem::path> truth;  ///< the simulator's truth.json
};

/// The configuration.
struct StudyConfig {
  std::filesystem::path file;
  std::string echo;      ///< the file's text
  double low_pass = 12;  ///< of both signals [Hz]
  std::vector<RunConfig> runs;
  std::optional<ArticleBeside> article;
};

/// Reads and checks a campaign. Its keys are
///  - `low_pass`;
///  - `runs`, a list, with `name`, `activity`, `reference` and `mems` (with the keys of `imu` in a replay, and
///   `name`), `gnss` (with the keys of a receiver), `phases` as in compare, and `truth`;
///  - `article`, optional: the file of an article (article.h) to compare with, and `article_sensors`, which maps
///   names of the campaign's sensors to names of the article's.
///
/// The `clock` of a studied IMU is not used, because the study estimates it; the reference's `clock` leads to GPS time.
/// Missing data files are no error here: a campaign is studied without a missing log.
/// Throws ConfigError `FILE:LINE: …`.
StudyConfig read_study_config(const std::filesystem::path& file);
StudyConfig read_study_config(const Config& config);

}  // namespace piste
