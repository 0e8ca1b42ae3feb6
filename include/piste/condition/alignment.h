#pragma once
/// How one IMU lies beside another: what their clocks, axes, places and constant errors differ by, and how surely.
/// condition/time_sync.h finds it.

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "piste/math/so3.h"

namespace piste {

/// Where the parameters stand in the covariance of an alignment.
struct AlignmentLayout {
  static constexpr int kClockOffset = 0, kClockDrift = 1, kBoresight = 2, kLeverArm = 5, kGyroBias = 8, kAccelBias = 11,
                       kGyroScale = 14, kAccelScale = 17, kSize = 20;
};

/// Correlation of the norms of the angular rates, which gave the first offset.
struct CorrelationPeak {
  std::vector<double> offset, correlation;  ///< clock offset [s], and coefficient, of all overlaps tried
  double peak_offset = 0, peak = 0;         ///< the best
  double rival = 0;                         ///< the highest coefficient elsewhere
};

/// Offset of the clocks in a stretch of the log, beside what the alignment says: zero if the clock runs evenly.
struct LocalOffset {
  double time = 0;  ///< middle of the stretch, reference time
  double offset = 0, sigma = 0;
};

struct Alignment {
  double clock_offset = 0;  ///< [s] at the first body sample
  double clock_drift = 0;   ///< ratio
  Quaterniond q_rb = Quaterniond::Identity();
  Vector3d p_rb_r = Vector3d::Zero();  ///< r → b, in r
  Vector3d gyro_bias = Vector3d::Zero(), accel_bias = Vector3d::Zero();
  Vector3d gyro_scale = Vector3d::Zero(), accel_scale = Vector3d::Zero();
  /// In the order of AlignmentLayout; boresight as rotation vector β in r, R_rb = Exp(β) R̂_rb. Rows of what is not
  /// determined are infinite on the diagonal and zero elsewhere.
  Eigen::Matrix<double, AlignmentLayout::kSize, AlignmentLayout::kSize> covariance;

  /// What the motion did not determine, in words, such as `lever arm: no rotation moves one IMU against the other`.
  std::vector<std::string> undetermined;
  /// What does not spoil the result, and yet should be known.
  std::vector<std::string> warnings;

  double low_pass = 0;                           ///< [Hz] that both signals went through
  double gyro_residual = 0, accel_residual = 0;  ///< rms of what is left in the band, one axis [rad/s], [m/s²]
  CorrelationPeak correlation;
  std::vector<LocalOffset> local;

  double variance(int index) const { return covariance(index, index); }
  Vector3d sigma(int block) const { return covariance.diagonal().segment<3>(block).cwiseSqrt(); }
  /// `value`, the parameters from `block` on, with zero for those that are not determined.
  Vector3d known(const Vector3d& value, int block) const {
    Vector3d out = value;
    for (int i = 0; i < 3; ++i) {
      if (!std::isfinite(variance(block + i))) out(i) = 0;
    }
    return out;
  }
  /// 1-sigma [rad] of roll, pitch and heading of R_rb; infinite for an angle that an undetermined rotation turns.
  Vector3d boresight_sigma() const;
  /// Time of the reference at time m of the body IMU's clock, whose first sample is at `first`.
  double reference_time(double m, double first) const { return m - clock_offset - clock_drift * (m - first); }
};

}  // namespace piste
