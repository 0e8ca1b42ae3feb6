#pragma once
/// A trajectory in a Cartesian frame, and its values between rows.

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "piste/trajectory/trajectory.h"

namespace piste {

/// Rows that are further apart are a gap, in which nothing is interpolated [s].
inline constexpr double kLongestInterpolation = 1;
/// Rows that are nearer are of one time [s].
inline constexpr double kSameTime = 1e-6;

/// The frame: east, north, up at a place on the Earth, or the axes of a file.
class EnuFrame {
 public:
  explicit EnuFrame(const Geodetic& origin) : world_(origin) {}
  Vector3d place(const Geodetic& place) const { return enu_from_ned() * world_.from_geodetic(place); }
  Geodetic geodetic(const Vector3d& place) const { return world_.to_geodetic(enu_from_ned().transpose() * place); }
  /// R_fn: from north, east, down at the place into the frame.
  Matrix3d local(const Geodetic& place) const {
    return enu_from_ned() * world_.rotation_wn(world_.from_geodetic(place));
  }
  static Matrix3d enu_from_ned() {
    Matrix3d R;
    R << 0, 1, 0, 1, 0, 0, 0, 0, -1;
    return R;
  }

 private:
  World world_;
};

/// One row in the frame. `local` is R_fn: of axes of their own, as if these were east, north, up.
struct FramedRow {
  double time = 0;
  Vector3d position;
  Matrix3d local = EnuFrame::enu_from_ned();
  Vector3d velocity = Vector3d::Zero();  ///< in the frame
  Quaterniond attitude = Quaterniond::Identity();
  Vector3d sigma_position = Vector3d::Zero(), sigma_velocity = Vector3d::Zero(), sigma_euler = Vector3d::Zero();
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
};

/// A trajectory whose rows are taken into a frame on demand.
class FramedPath {
 public:
  /// `frame`: of a trajectory on the Earth. `shift`: added to its times. The trajectory must outlive this.
  FramedPath(const Trajectory& track, std::optional<EnuFrame> frame, double shift = 0)
      : track_(track), frame_(std::move(frame)), shift_(shift) {}
  std::size_t size() const { return track_.size(); }
  double time(std::size_t i) const { return track_.time[i] + shift_; }
  double first() const { return time(0); }
  double last() const { return time(size() - 1); }
  bool has_velocity() const { return !track_.velocity.empty(); }
  bool has_attitude() const { return !track_.attitude.empty(); }
  const Trajectory& track() const { return track_; }
  FramedRow row(std::size_t i) const;
  /// The row within kSameTime of `time`, or interpolated. Nothing in a gap. @pre within the span, give or take
  /// kSameTime
  std::optional<FramedRow> at(double time) const;

 private:
  FramedRow between(std::size_t i, double time) const;
  const Trajectory& track_;
  std::optional<EnuFrame> frame_;
  double shift_;
};

}  // namespace piste
