#pragma once
/// What the IMU's own noise tells a filter of the scales, and takes it back.
///
/// A scale multiplies the measured rate, and this rate holds the noise that turns the attitude. So the effect of the
/// scale on the attitude and the error of the attitude have a common part, and every fix that shows the error pulls at
/// the scale (errors in variables; Fuller 1987). In an hour of calm driving this is many sigmas. The mean of the pull
/// is known: white noise of density q over a time T adds to the scores of the scales the diagonal of
///
///     q T Gᵀ Λ G (1 + s)⁻³
///
/// G: what the noise along the body's axes does to position, velocity and attitude until the next fix. Λ: the
/// information on these errors in all later fixes, as a smoother has it going backwards (Bierman 1973),
///
///     Λ = (I − K H)ᵀ Φᵀ Λ Φ (I − K H) + Hᵀ S⁻¹ H,   I − K H = P_after P_before⁻¹,
///
/// with the covariances for given errors of everything else. As a filter does not know later fixes, those so far stand
/// for them. The filter divides the measured rate by 1 + s, and the derivative divides it once more. Where one state is
/// measured directly, this is q T / (P_before + P_after): half the bandwidth with which fixes correct it.
/// Accelerometers likewise. A smoother that is linearised about a smoothed run (reference.h) needs none of this.
///
/// The effect of a scale seems larger than it is, too, by the noise in the rate, so that fixes seem to tell more of it.
/// This information is
///
///     q T diag(Gᵀ Λ G) (1 + s)⁻⁴
///
/// and is taken from the covariance by an update whose noise has the negative variance −1/information. The rate in the
/// Jacobian of a velocity does not count: it is shrunk by as much as its noise makes it larger (beyond_noise()).
///
/// The velocity of an antenna holds the same noise, as the rate swings the antenna about the IMU: its residual has −M
/// n, so that the fix moves the errors by K M n. This meets the noise in the rotation, and that in the rate of the
/// fix's own Jacobian, of which the part b is left. The two add to the scores
///
///     q diag(Gᵀ X + b Gᵀ X) (1 + s)⁻³,   X = Hᵀ S⁻¹ M − (I − K H)ᵀ Λ K M,
///
/// with Λ after the fix. A smoother takes the noise of rotation and velocity for independent. So its rates still hold
/// what the velocity tells of this noise; but what the fix did to them before and after it changes what is found of
/// their noise there. About a smoothed run the first term is
///
///     q diag(Gᵀ (I − 2 Λ N) X + 2 Gᵀ (I − K H)ᵀ B K M) (1 + s)⁻³
///
/// N: what the noise has made of the errors before the fix; its Λ is that before the fix. B: the same of the adjoint
/// after the fix.
///
///     N = Φ (I − K H) N (I − K H)ᵀ Φᵀ + q T G Gᵀ,   B = (I − K H)ᵀ Φᵀ B Φ (I − K H) + q T Λ G Gᵀ Λ

#include <optional>

#include "piste/core/options.h"
#include "piste/solve/tape.h"
#include "piste/solve/update.h"

namespace piste {

/// The score of the scales of gyroscopes and accelerometers, in this order.
using ScaleScore = Eigen::Matrix<double, 6, 1>;

/// What the noise has told of the scales.
struct ToldByNoise {
  ScaleScore score;        ///< by which its fixes have moved them, times their information
  ScaleScore information;  ///< that its fixes have only seemed to have, of each of them
};

/// Keeps how long the body has moved since the last fix, and what was known before it.
class NoiseScore {
 public:
  NoiseScore() = default;
  /// Where a reference attitude is measured, its fixes mend the gyroscopes' rate (rate_mending.h).
  NoiseScore(const FilterOptions& options, const StateLayout& layout);

  /// A step of `dt` seconds with the measured rate and force as factors of the scales. `gyro` and `accel`: factors of
  /// the variances of the stated noise.
  void add(double dt, double gyro = 1, double accel = 1) {
    duration_ += dt;
    gyro_time_ += gyro * dt;
    accel_time_ += accel * dt;
  }
  /// The same about a reference, whose rate and force are smoothed.
  void add_smoothed(double dt) { duration_ += dt; }
  /// Call it before a fix is used.
  void before_fix(const Estimate& x, const Covariance& P);
  /// Call it when a fix is used of which Linearization::by_rate_noise says that it holds this noise. `x`, `u`: before
  /// the fix. `gyro`: factor of the noise's variance. `smoothed`: as for add_smoothed().
  void swung(const Estimate& x, const Update& u, const Linearization& lin, double gyro = 1, bool smoothed = false);
  /// Call it after all fixes of one instant, before the next step. Returns what the noise has told in the fixes of the
  /// last half second or more; nothing where it waits for more. `gravity`: in the world frame.
  std::optional<ToldByNoise> after_fixes(const Estimate& x, const Covariance& P, const Vector3d& gravity);

 private:
  /// A covariance, or information, of the errors of position, velocity (its own, not the invariant one) and attitude.
  using Navigation = Eigen::Matrix<double, 9, 9>;
  static Navigation known(const Estimate& x, const Covariance& P);
  Navigation look_ahead(const Navigation& after, const Vector3d& pushed, const Navigation& made);

  double gyro_ = 0, accel_ = 0;  // densities of the white noise, squared; 0 where the scale is not estimated
  double duration_ = 0, gyro_time_ = 0, accel_time_ = 0;  // since the last score; the latter as the factors weigh it
  int fixes_ = 0;                                         // instants of them, likewise
  bool counted_ = false;                                  // whether the fixes of this instant are
  std::optional<Navigation> before_;
  // Sums since the last score: of the noise in Jacobians or in rotations, and of that in smoothed ones.
  struct Swing {
    Eigen::Matrix<double, 9, 3> corrected = Eigen::Matrix<double, 9, 3>::Zero();  // K M
    Eigen::Matrix<double, 9, 3> seen = Eigen::Matrix<double, 9, 3>::Zero();       // Hᵀ S⁻¹ M
  } noisy_, smoothed_;
  Navigation later_ = Navigation::Zero();  // Λ
  Navigation made_ = Navigation::Zero();   // N
  Navigation found_ = Navigation::Zero();  // B
  Vector3d velocity_ = Vector3d::Zero();   // at the last score
};

/// The update that takes information from the three scales of a block: a measurement of them with the negative variance
/// −1/information and no residual. At most a quarter of what is known of each is taken, so that the covariance stays
/// positive. Nothing where it is next to nothing.
std::optional<Update> taking(const Vector3d& information, const StateLayout& layout, Block scales, const Covariance& P);

/// The mean error that this score has brought: P times the score, for all states.
ErrorVector pull_of(const ScaleScore& score, const StateLayout& layout, const Covariance& P);

/// Adds a score to the adjoint of a smoother: λ of the scales.
void add_score(ErrorVector& lambda, const StateLayout& layout, const ScaleScore& score);

}  // namespace piste
