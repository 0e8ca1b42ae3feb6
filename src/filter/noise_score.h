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
/// with the covariances for given constants, of navigation and of all that changes as it does, such as drifts: what a
/// drift hides the fixes do not tell. As a filter does not know later fixes, those so far stand for them. The filter
/// divides the measured rate by 1 + s, and the derivative divides it once more. Where one state is measured directly,
/// this is q T / (P_before + P_after): half the bandwidth with which fixes correct it. Accelerometers likewise. A
/// smoother that is linearised about a smoothed run (reference.h) needs none of this.
///
/// What the filter does not know of the drift is in the rate as the noise is, and turns the attitude. It adds
///
///     −T diag(Gᵀ Λ Φ P_d) (1 + s)⁻²
///
/// with the covariance P_d of all these errors with that of the drift. With an accelerometer's drift of minutes this
/// is as much as the noise adds. It counts once the motion has lasted for the drift's correlation time: before, a drift
/// is as good as a bias, of which the filter knows no more.
///
/// The effect of a scale seems larger than it is, too, by the noise in the rate: of the information J + F that fixes
/// seem to have of it,
///
///     F = q T diag(Gᵀ Λ G) (1 + s)⁻⁴
///
/// is none, and is taken from the covariance by an update whose noise has the negative variance −1/F. What moves the
/// estimate at random has all of J + F, so that its variance is still larger than the covariance by F/J. To take 2 F
/// would make the two equal, at the price of larger errors: fixes of long ago would count for less. The rate in the
/// Jacobian of a velocity does not count: it is the mean one for the samples beside (model/rate_regression.h).
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

#include <array>
#include <optional>

#include "piste/core/options.h"
#include "piste/filter/update.h"

namespace piste {

/// The score of the scales of gyroscopes and accelerometers, in this order.
using ScaleScore = Eigen::Matrix<double, 6, 1>;

/// What the noise has told of the scales.
struct NoiseInformation {
  ScaleScore score;        ///< by which its fixes have moved them, times their information
  ScaleScore information;  ///< that its fixes have only seemed to have, of each of them
};

/// Keeps how long the body has moved since the last fix, and what was known before it.
class NoiseScore {
 public:
  /// s between two scores at least: several fixes of a fast receiver at a time, and each of one at 1 Hz, whose fixes
  /// may come somewhat early.
  static constexpr double kEvery = 0.9;

  NoiseScore() = default;
  /// Where a reference attitude is measured, its fixes mend the gyroscopes' rate (rate_mending.h).
  NoiseScore(const FilterOptions& options, const StateLayout& layout);

  /// A step of `dt` seconds with the measured rate and force as factors of the scales. `gyro` and `accel`: factors of
  /// the variances of the stated noise.
  void add(double dt, double gyro = 1, double accel = 1) {
    add_smoothed(dt);
    measured_ += dt;
    gyro_time_ += gyro * dt;
    accel_time_ += accel * dt;
  }
  /// The same about a reference, whose rate and force are smoothed.
  void add_smoothed(double dt) {
    duration_ += dt;
    lasted_ += dt;
    moved_ = true;
  }
  /// Call it before a fix is used.
  void before_fix(const Estimate& x, const Covariance& P);
  /// Call it when a fix is used of which Linearization::by_rate_noise says that it holds this noise. `x`, `u`: before
  /// the fix. `gyro`: factor of the noise's variance. `smoothed`: as for add_smoothed().
  void swung(const Estimate& x, const Update& u, const Linearization& lin, double gyro = 1, bool smoothed = false);
  /// Call it after all fixes of one instant, before the next step. Returns what the noise has told in the fixes of the
  /// last kEvery seconds or more; nothing where it waits for more. `gravity`: in the world frame.
  std::optional<NoiseInformation> after_fixes(const Estimate& x, const Covariance& P, const Vector3d& gravity);

 private:
  static constexpr int kNavigation = 9, kMost = 30;
  /// A covariance, or information, of what changes: the errors of position, velocity (its own, not the invariant one)
  /// and attitude, and those that are processes.
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMost, 3>;
  Square known(const Estimate& x, const Covariance& P) const;
  Square transition(double time, const Vector3d& force, const Estimate& x) const;
  Square look_ahead(const Square& after, const Square& until, const Square& made);
  void forget_swings();

  double gyro_ = 0, accel_ = 0;  // densities of the white noise, squared; 0 where the scale is not estimated
  // Of what changes: how much there is, its places in a StateLayout, and behind navigation the process of each.
  int size_ = kNavigation;
  std::array<int, kMost> states_{};
  std::array<DriftProcess, kMost> laws_{};
  int gyro_drift_ = -1, accel_drift_ = -1;  // first states, −1: none
  double lasted_ = 0;                       // all motion [s]
  double duration_ = 0;                     // since the last score
  double measured_ = 0;                     // of it, about measured rates
  double gyro_time_ = 0, accel_time_ = 0;   // the latter as the factors weigh it
  int fixes_ = 0;                           // instants of them, likewise
  bool moved_ = false;                      // since the last of these
  std::optional<Square> before_;
  // Sums since the last score: of the noise in Jacobians or in rotations, and of that in smoothed ones.
  struct Swing {
    Columns corrected, seen;  // K M, Hᵀ S⁻¹ M
  } noisy_, smoothed_;
  Square later_, made_, found_;           // Λ, N, B
  Vector3d velocity_ = Vector3d::Zero();  // at the last score
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
