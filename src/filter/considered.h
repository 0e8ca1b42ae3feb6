#pragma once
/// Errors of the IMU that its sensor file states and a run does not estimate. They are considered (Schmidt 1966; Groves
/// 2013, section 3.4.4): they are states whose covariance counts, and which no fix corrects.
///
/// With the optimal gain K = P Hᵀ S⁻¹ of all states, of which K_c are the rows of the considered ones,
///
///     δ_c = 0,   P ← (I − K H) P, and K_c S K_cᵀ is added to P_cc: the considered errors are as unknown as before.
///
/// This is the covariance of the filter that has zero rows for K_c. What is left out, K_c z, is not correlated with the
/// error after the optimal update. It therefore acts as noise of covariance K_c S K_cᵀ on the considered errors. A
/// smoother that takes it for such noise has the true covariance of its own error, because in
///
///     e_s = (e⁺ − C e⁻) + C e_s⁻,   C = P⁺ Φᵀ (P⁻)⁻¹,
///
/// the bracket is not correlated with e⁻, and e_s⁻ is made of e⁻ and of later noise alone.
///
/// Example: a tilt whose accelerometer has a bias of 0.05 m/s², stated and not in `estimate`. The sigma of the tilt
/// stays above 0.05/9.8 rad = 0.29 deg. Without the bias as a considered state it falls to 0.01 deg within a minute.

#include <vector>

#include "piste/filter/update.h"

namespace piste {

/// The blocks that a run considers: what `options.sensor` states and `options.estimate` does not name.
std::vector<Block> considered_blocks(const FilterOptions& options);

/// The layout of the filter's covariance: the estimated blocks, and those that are considered.
StateLayout filter_layout(const FilterOptions& options);

/// The rows and columns of `P`, which has the layout `from`, for the blocks of `to`.
Covariance restricted(const Covariance& P, const StateLayout& from, const StateLayout& to);

/// The considered states of a layout.
class Considered {
 public:
  Considered() = default;
  Considered(const FilterOptions& options, const StateLayout& layout);

  bool none() const { return states_.empty(); }
  /// The correction K z, without that of the considered states.
  ErrorVector correction(const Update& u) const;
  /// Sets the considered states of an error to zero.
  void hold(ErrorVector& error) const;
  /// The covariance after an update.
  void update(Covariance& P, const Update& u) const;
  /// By what an update moves the smoothed error of the considered states, relative to their estimate, which stays: K_c
  /// z
  /// + K_c S K_cᵀ λ_c. `lambda`: after the update.
  ErrorVector left_out(const Update& u, const ErrorVector& lambda) const;

  /// Calls `change`, after which the covariance of the considered states is as before.
  template <class Change>
  void keep(Covariance& P, Change&& change) const {
    const auto count = static_cast<Eigen::Index>(states_.size());
    Own own(count, count);
    for (Eigen::Index j = 0; j < count; ++j) {
      for (Eigen::Index i = 0; i < count; ++i) own(i, j) = P(state(i), state(j));
    }
    change();
    for (Eigen::Index j = 0; j < count; ++j) {
      for (Eigen::Index i = 0; i < count; ++i) P(state(i), state(j)) = own(i, j);
    }
  }

 private:
  static constexpr int kMost = 36;  // all errors of an IMU
  using Own = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
  Eigen::Index state(Eigen::Index i) const { return states_[static_cast<std::size_t>(i)]; }

  std::vector<Eigen::Index> states_;
};

}  // namespace piste
