#pragma once
/// What the IMU's own noise tells a filter of the scales, and takes it back.
///
/// A scale multiplies the measured rate, and this rate holds the noise that turns the attitude. So the effect of the
/// scale on the attitude and the error of the attitude have a common part, and every fix that shows the error pulls at
/// the scale (errors in variables; Fuller 1987). In an hour of calm driving this is many sigmas. The mean of the pull
/// is known: with white noise of density q, and the covariance P of the attitude about the body's axes before and after
/// the fixes of one instant, which come T later than those before, the scores of the scales rise by the diagonal of
///
///     q T (P_before + P_after)⁻¹
///
/// This is exact where fixes show the attitude itself or the velocity that follows from it; where positions alone show
/// it, the true value is a third larger. Whatever the noise is, the pull is half the bandwidth with which fixes correct
/// the attitude. Accelerometers likewise, with the velocity. A smoother that is linearised about a smoothed run
/// (reference.h) needs none of this.

#include <optional>

#include "piste/core/options.h"
#include "piste/solve/tape.h"

namespace piste {

/// The score of the scales of gyroscopes and accelerometers, in this order.
using ScaleScore = Eigen::Matrix<double, 6, 1>;

/// Keeps how long the body has moved since the last fix, and what was known before it.
class NoiseScore {
 public:
  NoiseScore() = default;
  /// Where a reference attitude is measured, its fixes mend the gyroscopes' rate (rate_mending.h).
  NoiseScore(const FilterOptions& options, const StateLayout& layout);

  /// A step of `dt` seconds with the measured rate and force as factors of the scales. `gyro` and `accel`: factors of
  /// the variances of the stated noise.
  void add(double dt, double gyro = 1, double accel = 1) {
    gyro_time_ += gyro * dt;
    accel_time_ += accel * dt;
  }
  /// Call it before a fix is used.
  void before_fix(const Estimate& x, const Covariance& P);
  /// Call it after all fixes of one instant, before the next step. Returns the score that they added; nothing if there
  /// was none.
  std::optional<ScaleScore> after_fixes(const Estimate& x, const Covariance& P);

 private:
  struct Known {
    Matrix3d attitude, velocity;
  };
  static Known known(const Estimate& x, const Covariance& P);

  double gyro_ = 0, accel_ = 0;            // densities of the white noise, squared; 0 where the scale is not estimated
  double gyro_time_ = 0, accel_time_ = 0;  // since the last fix, as the factors weigh it
  std::optional<Known> before_;
};

/// The mean error that this score has brought: P times the score, for all states.
ErrorVector pull_of(const ScaleScore& score, const StateLayout& layout, const Covariance& P);

/// Adds a score to the adjoint of a smoother: λ of the scales.
void add_score(ErrorVector& lambda, const StateLayout& layout, const ScaleScore& score);

}  // namespace piste
