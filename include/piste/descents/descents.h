#pragma once
/// Several runs of one course, compared: crossing times at gates, time gained in sections and along a line, each with
/// its sigma.
///
/// An error of position δp along the direction d of a gate, passed at the velocity v, is an error of the crossing time:
/// δt = −d · δp / (d · v). Errors of two runs are independent. Those of two epochs of one run are not, and a time from
/// gate to gate has the variance of both less twice their covariance, which the smoother gives.
///
///     Descent a = descent_of(read_replay_config("first.yaml"), {}), b = descent_of(read_replay_config("second.yaml"),
///     {}); const DescentReport found = compare_descents({a, b}, read_gates("gates.csv"), {});

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "piste/configuration/replay_config.h"
#include "piste/replay/replay.h"
#include "piste/trajectory/trajectory.h"

namespace piste {

/// Errors of crossing times: number i is −d · δp / (d · v) at a row of the run.
struct CrossingError {
  std::size_t row = 0;
  Vector3d factor;  ///< −d / (d · v), along east, north, up [s/m]
};

/// One run of the course.
struct Descent {
  std::string name;
  Trajectory track;                                ///< of the IMU, or of a point; with velocities
  std::shared_ptr<const Replay> replay = nullptr;  ///< with its history; null for a folder
  OutputPoint point = {};
  std::size_t first_row = 0;  ///< of a lap: that of its track among the rows of its replay

  /// E[x_i x_j] of errors of crossing times in ascending rows, for each i of `early` and all j ≥ i. @pre has a replay
  Eigen::MatrixXd covariances(const std::vector<CrossingError>& errors, const std::vector<std::size_t>& early) const;
  std::vector<double> variances(const std::vector<CrossingError>& errors) const;
};

/// Replays a configuration with its history. `at`: a point of `output: {at}`, or empty. Throws as replay(), and
/// ConfigError if there is no such point or no smoother.
Descent descent_of(const ReplayConfig& config, const std::string& at, std::string name = {});
/// The rows of a replay's folder; times gained have no sigma then. Throws as read_trajectory().
Descent descent_of(const std::filesystem::path& folder, const std::string& at, std::string name = {});

/// A gate: the vertical plane through a place, normal to a heading.
struct Gate {
  std::string name;
  Geodetic place;
  std::optional<double> heading = std::nullopt;  ///< rad; without it that of the line where it is nearest in plan
};

/// The laps of one log, named NAME_1, NAME_2 and so on. Each begins where the run passes the start within 15 m and 45°
/// of its direction, and ends where it does so again. The start is the first gate; without gates it is the earliest
/// place of the path that is passed most often. Only what passes all gates is a lap. Laps share their replay. Fewer
/// than two are no error here.
std::vector<Descent> laps_of(const Descent& run, const std::vector<Gate>& gates);

/// Reads gates in the order in which they are passed: `name, latitude_deg, longitude_deg`, optional `heading_deg`, a
/// cell of which may be empty. Throws DataError.
std::vector<Gate> read_gates(const std::filesystem::path& file);

/// Options of compare_descents().
struct DescentOptions {
  std::string line = {};  ///< name of the run that is the line, or `mean`; empty: the first run
  double common = 0;      ///< 1-sigma along the line that all runs share [m]: it is in times, not in gained times
  double step = 1;        ///< of the line [m]
};

/// A run at a plane. NaN where it is not known.
struct Crossing {
  double time = 0, sigma_time = 0;
  double offset = 0;                    ///< to the right of the gate, or of the line [m]
  double gained = 0, sigma_gained = 0;  ///< against the first run since the first gate; positive: less time
  double speed = 0;                     ///< m/s, in space
  double height = 0;                    ///< m, above the ellipsoid
  double radius = 0;                    ///< of the path, R = v³ / |v × a| [m]
  double load = 0;                      ///< |a − g| / g
};

/// A gate or a place of the line, with the crossing of each run.
struct Passage {
  std::string name;                       ///< empty: of the line
  double distance = 0;                    ///< along the line from the first gate [m]
  Vector3d place = Vector3d::Zero();      ///< of the gate or of the line: east, north, up of the first run's first row
  Vector3d direction = Vector3d::Zero();  ///< of the plane's normal, horizontal, in the same axes
  std::vector<Crossing> runs;
};

/// From gate to gate.
struct Section {
  std::string from, to;
  double length = 0;
  std::vector<double> duration, gained, sigma;  ///< of each run; of the first one gained and sigma are 0
};

/// The result.
struct DescentReport {
  std::vector<std::string> runs;
  std::string line, how_line;
  std::vector<Passage> gates, along;
  std::vector<Section> sections;
  std::vector<std::string> without_sigma;  ///< runs that are folders
};

/// Compares two runs or more, or the laps of one (laps_of). Gained times of two laps of one replay take the covariances
/// between all four crossings: they are not independent. Without gates these are the apexes of the line's turns. Laps
/// have one more, `lap`: the start line after the round; without gates also `start`. Throws
/// DataError if a run does not cross a gate forwards, ConfigError if the line is no run, names are repeated, or one run
/// has no laps.
DescentReport compare_descents(const std::vector<Descent>& runs, const std::vector<Gate>& gates,
                               const DescentOptions& options = {});

}  // namespace piste
