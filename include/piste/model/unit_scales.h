#pragma once
/// What the scales of several IMUs do to the mean of their outputs.
///
/// Unit i, which R_i turns into the axes of the first, adds R_i diag(s_i) R_iᵀ u. So the mean of a triad measures
///
///     û = (1 + S) u + b̄ + d̄ + noise,     S = Σ w_i R_i diag(s_i) R_iᵀ,     s_i = c_i s̄ + Σ_k S_ik ε_k
///
/// with the mean's own scales s̄ on the diagonal, and beside it a rest that is a linear function of s̄ and of the scale
/// blocks ε of the parities. The rest is taken off each step by the estimate; what is wrong with it acts as these
/// blocks do.

#include <array>
#include <memory>
#include <vector>

#include "piste/core/options.h"
#include "piste/model/strapdown.h"

namespace piste {

/// The rest above as a linear function of the estimated scales: its weights follow from the axes of the units, once a
/// run.
class UnitScales {
 public:
  /// @pre There are several units, and their axes are told.
  explicit UnitScales(const FilterOptions& options);
  /// Those of a run; nothing if there is no rest: every unit is turned by right angles, or there is one.
  static std::shared_ptr<const UnitScales> across(const FilterOptions& options);

  /// The measured step as it were if the mean had its own scales alone.
  ImuStep without_rest(const ImuStep& measured, const Estimate& x) const;
  /// Calls act(block, half, J) for every block of scales: its error times J adds to e_g (half 0) or e_a (half 3) of
  /// model/dynamics.h, where the true signals are `rate` and `force`.
  template <class Act>
  void for_each_effect(const Vector3d& rate, const Vector3d& force, Act&& act) const {
    for (std::size_t triad = 0; triad < 2; ++triad) {
      const Effects effects = effects_of(triad, triad == 0 ? rate : force);
      for (std::size_t k = 0; k < turned_.size(); ++k) act(block(triad, k), 3 * static_cast<int>(triad), effects[k]);
    }
  }

 private:
  using Effects = std::array<Matrix3d, kMostUnits>;

  static Block block(std::size_t triad, std::size_t k);
  Effects effects_of(std::size_t triad, const Vector3d& u) const;
  Matrix3d rest(std::size_t triad, const Estimate& x) const;

  std::vector<TurnedScale> turned_;  // of each unit
  /// Of gyroscopes and accelerometers, how much of s̄ and of each ε is in the scales of a unit (row), times its weight.
  std::array<Eigen::Matrix<double, kMostUnits, kMostUnits>, 2> parts_;
};

/// The same step if there is no rest.
inline ImuStep without_rest(const UnitScales* units, const ImuStep& measured, const Estimate& x) {
  return units != nullptr ? units->without_rest(measured, x) : measured;
}

}  // namespace piste
