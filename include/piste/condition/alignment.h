#pragma once
/// The alignment of two IMUs: how their clocks, axes, places and constant errors differ, with the covariance. align()
/// in condition/time_sync.h computes it.

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "piste/math/so3.h"

namespace piste {

/// First rows of the parameters in the covariance of an alignment.
struct AlignmentLayout {
  static constexpr int kClockOffset = 0, kClockDrift = 1, kBoresight = 2, kLeverArm = 5, kGyroBias = 8, kAccelBias = 11,
                       kGyroScale = 14, kAccelScale = 17, kSize = 20;
};

/// Correlation of the norms of the angular rates, from which the coarse offset comes.
struct CorrelationPeak {
  std::vector<double> offset, correlation;  ///< of all overlaps: clock offset [s], coefficient
  double peak_offset = 0, peak = 0;         ///< the best
  double rival = 0;                         ///< the highest coefficient outside that peak
};

/// Offset of the clocks in a stretch of the log relative to the alignment. It is zero if the clock runs evenly.
struct LocalOffset {
  double time = 0;  ///< middle of the stretch, reference time
  double offset = 0, sigma = 0;
};

/// The alignment of a body IMU b with a reference r.
struct Alignment {
  double clock_offset = 0;  ///< at the first body sample [s]
  double clock_drift = 0;   ///< a ratio: 1e-6 is 1 ppm
  Quaterniond q_rb = Quaterniond::Identity();
  Vector3d p_rb_r = Vector3d::Zero();  ///< lever arm from r to b, in r
  Vector3d gyro_bias = Vector3d::Zero(), accel_bias = Vector3d::Zero();
  Vector3d gyro_scale = Vector3d::Zero(), accel_scale = Vector3d::Zero();
  /// In the order of AlignmentLayout. The error of the boresight is a rotation vector β in r, R_rb = Exp(β) R̂_rb. The
  /// row of a parameter that the motion does not determine is infinite on the diagonal and zero elsewhere.
  Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize> covariance;

  /// The parameters that the motion does not determine, in words, such as `lever arm: no rotation moves one IMU against
  /// the other`.
  std::vector<std::string> undetermined;
  /// Warnings to the user about a usable result.
  std::vector<std::string> warnings;

  double low_pass = 0;                           ///< cut-off of both signals [Hz]
  double gyro_residual = 0, accel_residual = 0;  ///< rms of the residuals of one axis [rad/s], [m/s²]
  CorrelationPeak correlation;
  std::vector<LocalOffset> local;

  double variance(int index) const { return covariance(index, index); }
  Vector3d sigma(int block) const { return covariance.diagonal().segment<3>(block).cwiseSqrt(); }
  /// `value`, which are the parameters from row `block` on, with zero for those that are not determined.
  Vector3d known(const Vector3d& value, int block) const {
    Vector3d out = value;
    for (int i = 0; i < 3; ++i) {
      if (!std::isfinite(variance(block + i))) out(i) = 0;
    }
    return out;
  }
  /// 1-sigma [rad] of roll, pitch and heading of R_rb. Infinite for an angle that is not determined.
  Vector3d boresight_sigma() const;
  /// Time of the reference at time m of the body IMU's clock, whose first sample is at `first`.
  double reference_time(double m, double first) const { return m - clock_offset - clock_drift * (m - first); }
};

}  // namespace piste
