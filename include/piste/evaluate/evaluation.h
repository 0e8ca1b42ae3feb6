#pragma once
/// Compares a trajectory with a reference: absolute and relative pose errors (APE, RPE), errors over time with the
/// claimed sigmas, and the shares of errors within 1, 2, 3 sigma.
///
/// Both are taken into one Cartesian frame: east, north, up on the ellipsoid WGS84 at the reference's first row, with
/// the attitude of the body (forward, right, down) in it. A trajectory in axes of its own stays in them. The estimate
/// is moved onto the reference by least squares, b ≈ s R a + t (Umeyama 1991, IEEE PAMI 13). With the poses A and B:
///
///     APE: |a − b|, and the angle of R_b⁻¹ R_a      RPE: (B_i⁻¹ B_j)⁻¹ (A_i⁻¹ A_j)
///
/// Pairs of the RPE are consecutive (Zhang and Scaramuzza 2018, IROS): a pair ends at the first row at or beyond the
/// step along the reference's path, or of time, and there the next begins.
///
///     const Evaluation found = evaluate(read_trajectory({.path = "out/ski_run"}), read_trajectory({.path =
///     "truth.csv"})); found.ape.rmse;  // m

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/math/so3.h"
#include "piste/trajectory/trajectory.h"

namespace piste {

/// Which motion takes the estimate onto the reference.
enum class AlignmentKind {
  kNone,
  kPosition,  ///< a translation
  kYaw,       ///< and a rotation about the vertical
  kSe3,       ///< and any rotation
  kSim3       ///< and a scale
};
std::string_view name_of(AlignmentKind kind);
/// Throws ConfigError if there is no such kind.
AlignmentKind alignment_kind(std::string_view name);

/// The step of the relative error.
struct RelativeStep {
  double length = 0;         ///< m or s
  bool is_distance = false;  ///< along the reference's path, else in time
  std::string name() const;  ///< such as `100 m` or `1 s`
};
/// From text such as `100m`, `0.5 km` or `1 s`. Throws ConfigError if it is neither a length nor a time, or not above
/// zero.
RelativeStep relative_step(const std::string& text);

/// Options of evaluate().
struct EvaluationOptions {
  AlignmentKind align = AlignmentKind::kNone;
  std::vector<RelativeStep> steps = {{100, true}, {1, false}};
  /// Added to the estimate's times [s].
  double time_offset = 0;
  /// Whether the time offset is estimated, by least squares on the distances after the alignment, from within
  /// `search` [s] about `time_offset`.
  bool find_offset = false;
  double search = 2;
};

/// Sets the time offset from text: seconds, or `auto` for one that is estimated. Throws ConfigError if it is neither.
void set_time_offset(EvaluationOptions& options, const std::string& text);

/// Statistics of magnitudes; `std` is the root of the mean squared deviation from the mean.
struct ErrorStatistics {
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0;
};
/// @pre not empty
ErrorStatistics error_statistics(const std::vector<double>& magnitudes);

/// The motion b = scale · rotation · a + translation.
struct Similarity {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d translation = Vector3d::Zero();
  double scale = 1;
};

/// The least-squares motion of these points `a` onto `b`. Throws DataError if they do not determine it: fewer than two
/// points, or for a rotation points on one line.
Similarity align_points(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b, AlignmentKind kind);

/// The relative errors of one step. Without an attitude in both files the errors are those of the displacements.
struct RelativeErrors {
  RelativeStep step;
  std::size_t pairs = 0;
  std::optional<ErrorStatistics> distance = {}, rotation = {};  ///< m, rad; none without a pair, or an attitude
};

/// The nine errors that files have a sigma of, in the order of the columns of smoothed.csv.
inline constexpr std::size_t kNavigationErrors = 9;
/// Their names with units, such as `velocity_north_m_s`.
std::string_view navigation_error_name(std::size_t error);

/// One epoch. Errors are estimate minus reference after the alignment, in SI and radians. NaN: a file does not have it.
struct ErrorRow {
  double time = 0;
  std::array<double, kNavigationErrors> error, sigma;  ///< of north, east, down; their velocities; roll, pitch, heading
  double along = 0, across = 0, up = 0;  ///< of position: along and right of the reference's course, and up
  double distance = 0, angle = 0;        ///< the absolute pose error
  double nees = 0;                       ///< errorᵀ P⁻¹ error / 9, if the estimate has covariances
};

/// The result.
struct Evaluation {
  std::string estimate, reference;  ///< files
  EvaluationOptions options;
  std::vector<ErrorRow> rows;
  Similarity alignment;
  double time_offset = 0, sigma_time_offset = 0;  ///< added to the estimate's times [s]; sigma 0: not estimated
  ErrorStatistics ape;
  std::optional<ErrorStatistics> ape_rotation;
  double cep50 = 0, cep95 = 0;  ///< radii within which 50 % and 95 % of the horizontal errors lie
  std::vector<RelativeErrors> rpe;
  /// Shares of errors within 1, 2, 3 sigma; NaN where there is no sigma or no error.
  std::array<std::array<double, 3>, kNavigationErrors> within_sigma;
  std::optional<double> nees;            ///< mean over the epochs, per state
  std::size_t in_gaps = 0, outside = 0;  ///< rows left out: in a gap of the other file beyond 1 s; outside its span
  bool own_axes = false;                 ///< whether a file is in axes of its own
  std::vector<Vector3d> track_estimate, track_reference;  ///< east, north, up of each row

  bool has_sigmas() const;
};

/// Compares the estimate with the reference at the rows of the sparser file, where the other has a row within 1 µs or
/// rows at most 1 s apart around it. Between rows, places are interpolated by the cubic of the velocities, or linearly
/// without velocities, and attitudes by slerp. Throws DataError if the files have no time in common, with both spans.
Evaluation evaluate(const Trajectory& estimate, const Trajectory& reference, const EvaluationOptions& options = {});

}  // namespace piste
