#pragma once
/// The configuration of `study`: a campaign, whole.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/aligned.h"
#include "piste/core/options.h"
#include "piste/experiment/article.h"
#include "piste/io/align_config.h"
#include "piste/io/log_io.h"

namespace piste {

/// One run: a reference IMU, the receiver beside it, and the IMUs that are studied, all on one plate.
struct RunConfig {
  std::string name, activity;
  MountedImu reference;
  struct Receiver {
    LogFile log;
    GnssOptions options;  ///< whose lever arm goes from r to the antenna, in r
  };
  std::optional<Receiver> gnss;
  std::optional<Phases> phases;  ///< nothing = from the signals
  std::vector<MountedImu> mems;
  std::optional<std::filesystem::path> truth;  ///< the simulator's truth.json
};

struct StudyConfig {
  std::filesystem::path file;
  std::string echo;      ///< the file's text
  double low_pass = 12;  ///< [Hz] of both signals
  std::vector<RunConfig> runs;
  std::optional<ArticleBeside> article;
};

/// Reads and checks a campaign. Keys: `low_pass`; `runs`, a list of `name`, `activity`, `reference` and `mems` with the
/// keys of `imu` in a replay and `name`, `gnss` with those of a receiver, `phases` as in compare, and `truth`; and,
/// where the study is to stand beside an article, `article`, its file (article.h), and `article_sensors`, the names of
/// those of its sensors that some of the campaign's are held against, by the campaign's names. The `clock` of an IMU is
/// what is sought, and not used; that of the reference leads to GPS time. Whether the data files are there is not
/// looked at: a campaign with a missing log is studied without it. Throws ConfigError `FILE:LINE: …`.
StudyConfig read_study_config(const std::filesystem::path& file);
StudyConfig read_study_config(const Config& config);

}  // namespace piste
