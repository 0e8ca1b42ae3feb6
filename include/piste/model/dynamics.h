#pragma once
/// Transition of the error over one step, and of its covariance, by block.
///
/// With the error of estimate.h and w components, e_g = δbias + δdrift + diag(ω) δscale of the gyro, e_a likewise:
///
///     θ' = −[ω_ie] θ − R (1+s)⁻¹ e_g
///     ν' = [g] θ + [v][ω_ie] θ − 2[ω_ie] ν + Γ ρ − R (1+s)⁻¹ e_a − [v] R (1+s)⁻¹ e_g
///     ρ' = ν − [v] θ
///
/// Γ is the gradient of gravity. Neither the specific force nor its noise appears: derived from the mechanization
/// with δv = ν + θ × v̂ and the Jacobi identity.

#include "piste/core/options.h"
#include "piste/model/imu_errors.h"
#include "piste/model/strapdown.h"

namespace piste {

using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Matrix96d = Eigen::Matrix<double, 9, 6>;

/// The error over one step: navigation rows `navigation` (ρ, ν, θ) and `imu` (of e_g, e_a, held over the step);
/// every other block by itself.
struct Transition {
  Matrix9d navigation;
  Matrix96d imu;
  Vector3d rate, force;                           ///< mean corrected ω and f: what the scale errors multiply
  double bias = 1;                                ///< what the biases and drifts multiply
  Matrix9d noise;                                 ///< covariance that white sensor noise adds to the navigation rows
  std::array<double, kBlocks.size()> decay;       ///< per block: factor of its error; 1 where nothing evolves
  std::array<Vector3d, kBlocks.size()> variance;  ///< per block: what its process adds, per axis
};

/// Densities [unit²/Hz] of the white noise of one step, per body axis.
struct StepNoise {
  Vector3d gyro, accel;
};

/// Linearises one step that starts at `x` (before mechanize) and ends at `end`. `standing`: of a body that stands, what
/// gravity alone reads on its axes; velocity and rate are then exactly zero, so that no jitter tells anything of the
/// heading and of the scales. Null while it moves.
Transition linearize(const Estimate& x, const Estimate& end, const ImuStep& corrected, const Vector3d& earth_rate,
                     const Gravity& gravity, const StepNoise& noise, const Vector3d* standing = nullptr);

/// Mends the rate that the gyro's scale errors were propagated with, at no lapse of time: the measured rate holds the
/// gyro's noise, and where an attitude fix tells how far that noise has turned the estimate, by `noise_angle` (rotation
/// vector in w, truth − estimate), a scale regressed on the measured rate would take the noise for an effect of its
/// own (errors in variables). `x`: the estimate before the fix is used.
Transition mend_rate(const Estimate& x, const Vector3d& noise_angle);

/// Adds the processes of the estimated blocks over dt, as the state table gives them: drifts of the sensor and of the
/// boresight, coloured GNSS and attitude errors. No heap.
void add_processes(Transition& t, const StateLayout& layout, const FilterOptions& options, double dt);

/// P ← Φ P Φᵀ + Q, using that only the navigation rows mix. No heap.
void propagate(Covariance& P, const StateLayout& layout, const Transition& t);

/// Adjoint of the same step: λ ← Φᵀ λ and Λ ← Φᵀ Λ Φ. No heap.
void propagate_adjoint(ErrorVector& lambda, Covariance& Lambda, const StateLayout& layout, const Transition& t);

/// Φ as a dense matrix of the layout's size, for tests and for small problems.
Covariance dense_transition(const StateLayout& layout, const Transition& t);

/// Mean evolution of the blocks that are processes, such as drifts: they decay.
void decay(Estimate& x, const StateLayout& layout, const Transition& t);

}  // namespace piste
