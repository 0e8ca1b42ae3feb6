#pragma once
/// The effect of the scales of several IMUs on the mean of their outputs.
///
/// IMU i, which R_i turns into the axes of the first, adds R_i diag(s_i) R_iᵀ u. So the mean of a triad measures
///
///     û = (1 + S) u + b̄ + d̄ + noise,     S = Σ w_i R_i diag(s_i) R_iᵀ,     s_i = c_i s̄ + Σ_k S_ik ε_k
///
/// with the mean's own scales s̄ on the diagonal. The remainder S − diag(s̄) is a linear function of s̄ and of the
/// scale blocks ε of the parities. Each step is corrected for the estimated remainder; its error acts as the errors of
/// these blocks do.

#include <array>
#include <memory>
#include <vector>

#include "piste/core/options.h"
#include "piste/model/strapdown.h"

namespace piste {

/// The remainder above as a linear function of the estimated scales: its weights follow from the axes of the IMUs, once
/// per run.
class ImuScales {
 public:
  /// @pre There are several IMUs, and their axes are given.
  explicit ImuScales(const FilterOptions& options);
  /// The remainder of a run; nothing if it is zero: every IMU is turned by right angles, or there is one.
  static std::shared_ptr<const ImuScales> across(const FilterOptions& options);

  /// The measured step without the remainder, as if the mean had only its own scales.
  ImuStep without_rest(const ImuStep& measured, const Estimate& x) const;
  /// Calls act(block, half, J) for every block of scales, at the true signals `rate` and `force`. Its error times J
  /// adds to e_g (half 0) or e_a (half 3) of model/dynamics.h.
  template <class Act>
  void for_each_effect(const Vector3d& rate, const Vector3d& force, Act&& act) const {
    for (std::size_t triad = 0; triad < 2; ++triad) {
      const Effects effects = effects_of(triad, triad == 0 ? rate : force);
      for (std::size_t k = 0; k < turned_.size(); ++k) act(block(triad, k), 3 * static_cast<int>(triad), effects[k]);
    }
  }

 private:
  using Effects = std::array<Matrix3d, kMostImus>;

  static Block block(std::size_t triad, std::size_t k);
  Effects effects_of(std::size_t triad, const Vector3d& u) const;
  Matrix3d rest(std::size_t triad, const Estimate& x) const;

  std::vector<TurnedScale> turned_;  // of each IMU
  /// Of gyroscopes and accelerometers, the share of s̄ and of each ε in the scales of an IMU (row), times its weight.
  std::array<Eigen::Matrix<double, kMostImus, kMostImus>, 2> parts_;
};

/// The same step if there is no remainder.
inline ImuStep without_rest(const ImuScales* imus, const ImuStep& measured, const Estimate& x) {
  return imus != nullptr ? imus->without_rest(measured, x) : measured;
}

}  // namespace piste
