#pragma once
/// The least-squares problem of an alignment: its parameters, its residuals and its solution.

#include <Eigen/Core>
#include <vector>

#include "determination.h"
#include "paired_signals.h"
#include "piste/condition/alignment.h"

namespace piste {

/// The estimated parameters: those of the alignment, and the in-run drifts of the body IMU at knots.
struct AlignmentState {
  Eigen::Vector2d clock = Eigen::Vector2d::Zero();  ///< offset, drift
  Quaterniond q_rb = Quaterniond::Identity();
  Vector3d p_rb_r = Vector3d::Zero();
  Vector3d gyro_bias = Vector3d::Zero(), accel_bias = Vector3d::Zero();
  Vector3d gyro_scale = Vector3d::Zero(), accel_scale = Vector3d::Zero();
  double first_knot = 0, knot_spacing = 1;        ///< on the body IMU's clock
  std::vector<Vector3d> gyro_drift, accel_drift;  ///< linear from knot to knot

  /// The place of time m among the knots: the index of the knot before, and the part of the way to the next (0 to 1).
  std::pair<std::size_t, double> knot(double m) const;
  /// The drift at time m, of gyroscopes or accelerometers.
  Vector3d drift(const std::vector<Vector3d>& knots, double m) const;
  /// Time of the reference at time m of the body IMU's clock, whose first sample is at `first`.
  double reference_time(double m, double first) const { return m - clock(0) - clock(1) * (m - first); }
};

/// One sample of the body IMU in the problem, with the sigmas of its weights.
struct AlignmentEpoch {
  std::size_t sample = 0;
  UsableAxes usable;
  double gyro_sigma = 1, accel_sigma = 1;
  bool moving = false;  ///< whether the body is in motion (alignment_epochs.h)
};

/// 1/sigma for the axes that are usable, 0 for the others.
Vector3d weights(std::uint8_t usable, double sigma);

/// Measured minus predicted at one sample.
struct AlignmentResidual {
  Vector3d gyro, accel;
};

AlignmentResidual residual(const FilteredPair& pair, const AlignmentState& x, std::size_t sample);

/// Solves the problem for x, with Huber's loss for each triad beyond 4 sigma. Returns the information matrix of the
/// parameters in the order of AlignmentLayout, with the drifts eliminated. Rows of an error that the sensor does not
/// have (a scale with sigma 0) are zero.
Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize> solve_alignment(
    const FilteredPair& pair, const std::vector<AlignmentEpoch>& epochs, const ImuSensor& sensor, AlignmentState& x);

}  // namespace piste
