#pragma once
/// The readers behind trajectory.h, and how each format is recognised.

#include <string_view>

#include "piste/trajectory/trajectory.h"

namespace piste::trajectory_formats {

/// The first bytes of a file, and its rows.
struct FileStart {
  std::filesystem::path path;
  std::string_view text;       ///< the first kilobytes
  std::uintmax_t size = 0;     ///< of the whole file [bytes]
  std::string_view first_row;  ///< the first line that is no comment (# or %)
  std::size_t numbers = 0;     ///< in that line if it has nothing else, separated by blanks or commas
  bool commas = false;         ///< whether it has a comma
};

Trajectory read_csv(const std::string& file);
Trajectory read_tum(const std::string& file);
Trajectory read_kitti(const std::string& file);
Trajectory read_euroc(const std::string& file);
Trajectory read_kf_gins(const std::string& file);
Trajectory read_rtklib(const std::string& file);
Trajectory read_nmea(const std::string& file);
Trajectory read_sbet(const std::string& file);
Trajectory read_inertial_explorer(const std::string& file);
Trajectory read_mapping(const std::string& file);

bool is_csv(const FileStart& start);
bool is_tum(const FileStart& start);
bool is_kitti(const FileStart& start);
bool is_euroc(const FileStart& start);
bool is_kf_gins(const FileStart& start);
bool is_rtklib(const FileStart& start);
bool is_nmea(const FileStart& start);
bool is_sbet(const FileStart& start);
bool is_inertial_explorer(const FileStart& start);
bool is_mapping(const FileStart& start);

}  // namespace piste::trajectory_formats
