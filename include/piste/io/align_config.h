#pragma once
/// The configuration of `align` and `compare`, whole.

#include <filesystem>
#include <string>
#include <vector>

#include "piste/core/aligned.h"
#include "piste/core/options.h"
#include "piste/io/imu_source.h"

namespace piste {

/// A body IMU beside the reference.
struct MountedImu {
  std::string name;  ///< of its outputs where there are several: key `name`, else the stem of its file
  ImuSource source;
  ConditioningOptions conditioning;
};

/// Reads the keys of `imu` in a replay, and `name`, which becomes the name of a folder. Throws ConfigError.
MountedImu read_mounted_imu(const Config& config, DataFile data = DataFile::kMustExist);

/// The key `phases: auto`, or `{before: [t0, t1], run: [t0, t1], after: [t0, t1]}`, of which any may be left out;
/// nothing for `auto` and where the key is absent. Throws ConfigError.
std::optional<Phases> read_phases(const Config& config);

struct AlignConfig {
  std::filesystem::path file;
  std::string echo;              ///< the file's text
  std::vector<MountedImu> imus;  ///< one, or several on the same plate, each with a clock of its own
  MountedImu reference;
  double low_pass = 0;           ///< [Hz] of both signals; 0 = as suits them
  std::optional<Phases> phases;  ///< of compare; nothing = from the signals
};

/// Reads and checks the configuration; of the data files only that they are there. Keys: `imu`, a map or a list of
/// maps, and `reference`, with the keys of `imu` in a replay and `name`; `low_pass`; `span: {start, end}` of the body
/// IMU's clock; for compare, `phases` in the reference's time. The `clock` of a body IMU is what is sought, and not
/// used; that of the reference leads to GPS time. Throws ConfigError `FILE:LINE: …`.
AlignConfig read_align_config(const std::filesystem::path& file);
AlignConfig read_align_config(const Config& config);

}  // namespace piste
