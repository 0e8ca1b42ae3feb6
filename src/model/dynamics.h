#pragma once
/// How the error of an estimate, and its covariance, change over one IMU step.
///
/// The error is that of estimate.h, in w. e_g is the error of the gyroscopes' model, δbias + δdrift + diag(ω) δscale +
/// … (imu_error_model.h), and e_a likewise that of the accelerometers (for the scales of several IMUs see ImuScales):
///
///     θ' = −[ω_ie] θ − R (1+s)⁻¹ e_g
///     ν' = [g] θ + [v][ω_ie] θ − 2[ω_ie] ν + Γ ρ − R (1+s)⁻¹ e_a − [v] R (1+s)⁻¹ e_g
///     ρ' = ν − [v] θ
///
/// (1+s)⁻¹ is diagonal: products of a cross-axis error with e_g or e_a are of second order, and left out. Γ is the
/// gradient of gravity. Neither the specific force nor its noise appears. The equations follow from the
/// mechanization with δv = ν + θ × v̂ and the Jacobi identity.

#include "model/imu_errors.h"
#include "model/imu_scales.h"
#include "piste/core/options.h"
#include "piste/model/strapdown.h"

namespace piste {

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Matrix96d = Eigen::Matrix<double, 9, 6>;

/// White noise of one step: its densities squared [unit²/Hz], per body axis.
struct StepNoise {
  Vector3d gyro, accel;
};

/// The quantities in the equations above, at the middle of one step: its transition follows from them.
struct ErrorStep {
  double dt;  ///< 0: not a step, but mend_rate()
  Quaterniond q_wb;
  Vector3d v_wb, rate, force;        ///< v̂; ω and f as the scale errors multiply them
  Vector3d gyro_scale, accel_scale;  ///< s
  struct Around {
    Vector3d gravity;   ///< g
    Matrix3d gradient;  ///< Γ
    StepNoise noise;
    bool operator==(const Around& other) const {
      return gravity == other.gravity && gradient == other.gradient && noise.gyro == other.noise.gyro &&
             noise.accel == other.noise.accel;
    }
  } around;  ///< what changes seldom
};

/// The transition Φ of one step, and the noise that the step adds. The navigation error (ρ, ν, θ) depends on itself and
/// on the errors of the IMU; every other block depends on itself alone.
struct Transition {
  Matrix9d navigation;                            ///< of (ρ, ν, θ) on itself
  Matrix96d imu;                                  ///< of (ρ, ν, θ) on (e_g, e_a), which are constant over the step
  Vector3d rate, force;                           ///< mean corrected ω and f: factors of the scale errors
  double bias = 1;                                ///< factor of the biases and drifts
  Matrix9d noise;                                 ///< covariance that white sensor noise adds to the navigation rows
  std::array<double, kBlocks.size()> decay;       ///< per block: factor of its error; 1 where nothing evolves
  std::array<Vector3d, kBlocks.size()> variance;  ///< per block: what its process adds, per axis
  ErrorStep step;                                 ///< the step of which all but decay and variance are made
  const ImuScales* imu_scales = nullptr;          ///< of several IMUs whose scales act across the axes of their mean
};

/// Linearises one step that starts at `x` (before mechanize) and ends at `end`. `standing` is for a body at rest: the
/// specific force that gravity alone causes on its axes. Velocity and rate are then taken as exactly zero, so that
/// their noise gives no false information on heading and scales. It is null while the body moves.
Transition linearize(const Estimate& x, const Estimate& end, const ImuStep& corrected, const Vector3d& earth_rate,
                     const Gravity& gravity, const StepNoise& noise, const Vector3d* standing = nullptr);

/// The transition of `step`, without processes. The Earth's rotation is in w. Where no time passes, that of
/// mend_rate().
Transition linearize(const ErrorStep& step, const Vector3d& earth_rate);

/// The errors-in-variables correction of the rate with which the error of the gyroscope's scale was propagated, as a
/// transition that takes no time. That rate was measured and so contains the gyroscope's noise. An attitude fix then
/// removes the rotation that this noise caused. If the rate stayed as it was, the filter would take that rotation for
/// an effect of the scale. `noise_angle`: the rotation, as the fix observes it (rotation vector in w, truth −
/// estimate). `x`: the estimate before the fix is used.
Transition mend_rate(const Estimate& x, const Vector3d& noise_angle);

/// Sets decay and variance over dt of the estimated blocks that are processes, by the state table. These are drifts of
/// the sensor and of the boresight, and coloured errors of GNSS and of reference attitudes. No heap.
void add_processes(Transition& t, const StateLayout& layout, const FilterOptions& options, double dt);

/// P ← Φ P Φᵀ + Q. Uses that only the navigation rows depend on other blocks. No heap.
void propagate(Covariance& P, const StateLayout& layout, const Transition& t);

/// m ← Φ m for an error. No heap.
void propagate(ErrorVector& m, const StateLayout& layout, const Transition& t);

/// Φ as a dense matrix of the layout's size, for tests and for small problems.
Covariance dense_transition(const StateLayout& layout, const Transition& t);

/// Multiplies the values of the blocks that are processes, such as drifts, by their decay over the step.
void decay(Estimate& x, const StateLayout& layout, const Transition& t);

}  // namespace piste
