#pragma once
/// The errors-in-variables correction of the IMU's scales: the mean of the false score that the IMU's own noise brings.
///
/// A scale multiplies the measured rate, and this rate holds the noise n that turns the attitude. So the error e of the
/// attitude, and its derivative D_j by the scale j of an axis, have a common part. Every fix that observes e pulls at
/// the scale (errors in variables; Fuller 1987). In an hour of calm driving this is many sigmas. The correction
/// subtracts the mean of this pull (a corrected score; Nakamura 1990, Stefanski and Carroll 1987).
///
/// e holds the errors of navigation and of all processes such as drifts, for given constants. With δD_j, the part of
/// D_j that comes from noise, and g_j, the column of the axis among the errors (R e_j for attitude or velocity), a step
/// and a fix with the noise v are
///
///     e ← Φ e − g_j n_j (1+s)⁻¹,   δD_j ← Φ δD_j − g_j n_j (1+s)⁻²
///     z = H e + v,   e ← (I − K H) e − K v,   δD_j ← (I − K H) δD_j
///
/// A fix adds D_jᵀ Hᵀ S⁻¹ z to the score of scale j. So with C_j = E[e δD_jᵀ] and white noise of density q, the mean of
/// the false score is a sum over the fixes:
///
///     step:  C_j ← Φ C_j Φᵀ + q dt g_j g_jᵀ (1+s)⁻³ − dt Φ P_d g_jᵀ (1+s)⁻²
///     fix:   score_j += tr(Hᵀ S⁻¹ H C_j),   C_j ← (I − K H) C_j (I − K H)ᵀ
///
/// P_d is the column of the covariance for the drift of the axis: its unknown error is in the measured rate, too. This
/// term counts once the motion has lasted for the drift's correlation time. Before that a drift is as good as a bias,
/// which is one of the given constants. P, S and K are those of the filter for given constants: P without what the
/// constants explain (Schur's complement).
///
/// The noise also makes the effect of a scale seem larger than it is. Of the information J + F that the fixes seem to
/// have of it, F is false:
///
///     step:  N_j ← Φ N_j Φᵀ + q dt g_j g_jᵀ (1+s)⁻⁴
///     fix:   F_j += tr(Hᵀ S⁻¹ H N_j),   N_j ← (I − K H) N_j (I − K H)ᵀ
///
/// F is removed from the covariance by an update whose noise has the negative variance −1/F.
///
/// The velocity of an antenna holds the noise of the current sample directly, because the rate swings the antenna about
/// the IMU. The residual then has the part −M n, and the derivative of the prediction by the scale has −b M n, where b
/// is the part of the noise in the rate of the Jacobian (model/rate_regression.h). With a = H g_j and m = M e_j:
///
///     score_j += q (1 + b) mᵀ S⁻¹ a (1+s)⁻³
///     C_j     −= q (k cᵀ + b c kᵀ) (1+s)⁻³,   k = K m,  c = (I − K H) g_j
///
/// Φ over the time between two fixes uses the mean specific force. Example: a gyroscope of 0.05 deg/s/√Hz, and a fix
/// every second that knows an attitude to 1 deg before and 0.5 deg after it. The score of that axis is q T / (P₋ + P₊)
/// = 0.0025 / 1.25 = 0.002 a fix. In an hour this moves a scale known to 1 % by (0.01)² · 7.2 = 720 ppm.
///
/// About a smoothed run (reference.h) the rates no longer hold the noise, but for the part that velocities could not
/// show: the smoother takes the noise of a velocity and that of the rotation for independent. One half of the terms of
/// k and of mᵀ S⁻¹ a remains. All else is zero there. The exact mean in tests/filter/errors_in_variables.cpp is 0.65.

#include <array>
#include <optional>

#include "piste/core/options.h"
#include "piste/filter/update.h"

namespace piste {

/// The score of the scales of gyroscopes and accelerometers, in this order.
using ScaleScore = Eigen::Matrix<double, 6, 1>;

/// The part of score and information of the scales that comes from the noise of the IMU.
struct FalseInformation {
  ScaleScore score;        ///< by which the fixes have moved the scales, times their information
  ScaleScore information;  ///< F, of each of them
};

/// The recursion over the run. No heap.
class ErrorsInVariables {
 public:
  /// s of motion between two corrections at least: several fixes of a fast receiver at a time, and each of one at 1 Hz,
  /// whose fixes may come somewhat early.
  static constexpr double kEvery = 0.9;

  ErrorsInVariables() = default;
  /// Where a reference attitude is measured, its fixes correct the gyroscopes' rate (rate_mending.h).
  ErrorsInVariables(const FilterOptions& options, const StateLayout& layout);

  /// A step of `dt` seconds under way, with the measured rate and force as factors of the scales. `gyro` and `accel`:
  /// factors of the variances of the stated noise.
  void add(double dt, double gyro = 1, double accel = 1) {
    add_smoothed(dt);
    measured_ += dt;
    gyro_time_ += gyro * dt;
    accel_time_ += accel * dt;
  }
  /// The same about a smoothed run.
  void add_smoothed(double dt) {
    duration_ += dt;
    since_ += dt;
    lasted_ += dt;
  }
  /// Call it for every update `u` by a fix, before it changes the estimate `x` with the covariance `P`. `gravity` is in
  /// the world frame. `lin`: of the fix; by_rate_noise is M and observed_noise b. `smoothed`: about a smoothed run.
  /// Fixes at rest count until they observe no more of the noise.
  void observe(const Estimate& x, const Covariance& P, const Vector3d& gravity, const Update& u,
               const Linearization& lin, double gyro = 1, bool smoothed = false);
  /// Call it when the covariance has been changed by other means than fixes and steps.
  void covariance_changed() { known_ = false; }
  /// Call it after all fixes of one instant, before the next step. Returns what has been summed up, once in kEvery
  /// seconds of motion.
  std::optional<FalseInformation> after_fixes(const Estimate& x);

 private:
  static constexpr int kNavigation = 9, kMost = 21;
  /// C_j and N_j of the six scales, side by side: the number of one element is contiguous over these lanes.
  static constexpr std::ptrdiff_t kLanes = 12, kOfScore = 6;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMost, 3>;
  Square for_given_constants(const Estimate& x, const Covariance& P) const;
  bool corrects_any() const { return of_gyro_ || of_accel_; }
  Square transition(double time, const Vector3d& force, const Estimate& x) const;
  bool counts(int drift) const;
  void propagate(const Estimate& x, const Vector3d& gravity);
  double* at(std::ptrdiff_t row, std::ptrdiff_t column) { return moments_.data() + (row * size_ + column) * kLanes; }

  double gyro_ = 0, accel_ = 0;              // densities of the white noise, squared
  bool of_gyro_ = false, of_accel_ = false;  // whether the scales are estimated, and corrected here
  // Of the errors that change: their number, their places in a StateLayout, and behind navigation the process of each.
  int size_ = kNavigation;
  std::array<int, kMost> states_{};
  std::array<DriftProcess, kMost> laws_{};
  int gyro_drift_ = -1, accel_drift_ = -1;  // first states, −1: none
  double lasted_ = 0;                       // all motion [s]
  double since_ = 0;                        // motion since the last correction
  double duration_ = 0;                     // motion since the last instant with fixes
  double measured_ = 0;                     // of it, about measured rates
  double gyro_time_ = 0, accel_time_ = 0;   // the same, as the factors weigh it
  bool instant_ = false;                    // whether fixes of this instant were observed
  bool known_ = false;                      // whether P_ is that of the filter
  Vector3d velocity_ = Vector3d::Zero();    // at the last instant with fixes
  Square P_;                                // for given constants, after the last fix
  Columns turn_;                            // g_j of the gyroscopes after the fixes of this instant so far
  FalseInformation sum_{ScaleScore::Zero(), ScaleScore::Zero()};
  alignas(64) std::array<double, std::size_t{kMost} * kMost * kLanes> moments_{};
};

/// The update that removes information from the three scales of a block: a measurement of them with the negative
/// variance −1/information and no residual. At most a quarter of what is known of each is removed, so that the
/// covariance stays positive. Returns nothing where it is next to nothing.
std::optional<Update> removing(const Vector3d& information, const StateLayout& layout, Block scales,
                               const Covariance& P);

/// The mean error that this score has brought: P times the score, for all states.
ErrorVector pull_of(const ScaleScore& score, const StateLayout& layout, const Covariance& P);

/// Adds a score to the adjoint of a smoother: λ of the scales.
void add_score(ErrorVector& lambda, const StateLayout& layout, const ScaleScore& score);

}  // namespace piste
