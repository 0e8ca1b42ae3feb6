#pragma once
/// Trajectories as files have them, of piste and of other programs.
///
///     const Trajectory track = read_trajectory({.path = "out/ski_run"});   // its smoothed.csv
///     const Trajectory other = read_trajectory({.path = "orb_slam.tum"});  // the format is recognised

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/math/earth.h"

namespace piste {

/// Formats of trajectories that read_trajectory() knows.
enum class TrajectoryFormat {
  kCsv,               ///< columns named as in smoothed.csv and truth.csv; others are skipped
  kTum,               ///< `t x y z qx qy qz qw`
  kKitti,             ///< rows of a 3 × 4 matrix; times stand in STEM_times.txt or times.txt
  kEuroc,             ///< `t [ns], x, y, z, qw, qx, qy, qz`, further columns are skipped
  kKfGins,            ///< `week t latitude longitude height velocity(3) roll pitch yaw`, degrees
  kRtklibPos,         ///< a solution of RTKLIB
  kNmea,              ///< sentences of a receiver
  kSbet,              ///< binary, 17 doubles a row; accuracies stand in STEM_smrmsg.out
  kInertialExplorer,  ///< text of Inertial Explorer with a line of names and one of units
  kMapping            ///< a configuration (YAML) with the keys `gnss` and `attitude` of replay
};

/// Its name on the command line, such as `kf_gins`.
std::string_view name_of(TrajectoryFormat format);
/// All names, separated by commas.
std::string trajectory_format_names();
/// The format of that name. Throws ConfigError if there is none.
TrajectoryFormat trajectory_format(std::string_view name);

/// A trajectory. Members that the file does not have are empty; the others have one element for each row.
struct Trajectory {
  std::string file;
  TrajectoryFormat format = TrajectoryFormat::kCsv;
  /// Whether places are on the Earth, so that velocities are along north, east, down and attitudes are R_nb. Otherwise
  /// `position` is in the axes of the file, and so are velocities and attitudes.
  bool geodetic = true;
  bool has_time = true;            ///< else `time` counts the rows
  std::vector<double> time;        ///< increasing [s]
  std::vector<Geodetic> place;     ///< if geodetic
  std::vector<Vector3d> position;  ///< if not geodetic
  std::vector<Vector3d> velocity;
  std::vector<Quaterniond> attitude;
  std::vector<Vector3d> sigma_position, sigma_velocity, sigma_euler;  ///< north, east, down; roll, pitch, heading
  /// Covariance of position, velocity (north, east, down) and the angles (roll, pitch, heading), in SI and radians.
  std::vector<Eigen::Matrix<double, 9, 9>> covariance;

  std::size_t size() const { return time.size(); }
};

/// What is read, and how.
struct TrajectoryFile {
  /// A file, or the folder of a replay: of it `smoothed.csv`, or else `filtered.csv`.
  std::filesystem::path path;
  std::optional<TrajectoryFormat> format = std::nullopt;  ///< without it, it is recognised
  std::string at = {};  ///< the named point of `output: {at}`: the file STEM_NAME.csv of the same run
};

/// Reads a trajectory. Throws DataError `FILE:LINE: …` if a row cannot be read, or if the format is not recognised.
Trajectory read_trajectory(const TrajectoryFile& from);

}  // namespace piste
