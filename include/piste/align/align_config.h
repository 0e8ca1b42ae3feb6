#pragma once
/// Reads the configuration of `align` and `compare`.

#include <filesystem>
#include <string>
#include <vector>

#include "piste/configuration/imu_source.h"
#include "piste/core/aligned.h"
#include "piste/core/options.h"

namespace piste {

/// One IMU on the plate.
struct MountedImu {
  std::string name;  ///< name of its output folder if there are several IMUs: the key `name`, else the stem of its file
  ImuSource source;
  ConditioningOptions conditioning;
};

/// Reads one IMU: the keys of `imu` in a replay, and `name`. Throws ConfigError.
MountedImu read_mounted_imu(const Config& config, DataFile data = DataFile::kMustExist);

/// Reads the key `phases`: `auto`, or `{before: [t0, t1], run: [t0, t1], after: [t0, t1]}`. Each phase is optional.
/// Returns nothing for `auto` and if the key is missing. Throws ConfigError.
std::optional<Phases> read_phases(const Config& config);

/// The configuration.
struct AlignConfig {
  std::filesystem::path file;
  std::string echo;              ///< the file's text
  std::vector<MountedImu> imus;  ///< one or several on the same plate, each with its own clock
  MountedImu reference;
  double low_pass = 0;           ///< of both signals [Hz]; 0 = chosen by align()
  std::optional<Phases> phases;  ///< of compare; nothing: detected in the signals
};

/// Reads and checks the configuration. It only checks that the data files exist. Keys: `imu`, a map or a list of maps,
/// and `reference`, both with the keys of `imu` in a replay and `name`; `low_pass`; `span: {start, end}` on the body
/// IMU's clock; for compare, `phases` in the reference's time. The `clock` of a body IMU is not used, because `align`
/// estimates it. The `clock` of the reference leads to GPS time. Throws ConfigError `FILE:LINE: …`.
AlignConfig read_align_config(const std::filesystem::path& file);
AlignConfig read_align_config(const Config& config);

}  // namespace piste
