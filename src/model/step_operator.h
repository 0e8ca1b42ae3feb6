#pragma once
// The transition of a step, applied to vectors without being formed.
//
// With A and B of the error's equation (model/dynamics.h), Φ = 1 + A dt + ½ A² dt² acts through two cross products and
// two 3×3 products per application of A. `linearize` forms the same Φ as matrices.

#include <array>
#include <vector>

#include "model/dynamics.h"
#include "model/imu_error_model.h"

namespace piste {

/// Applies steps for one layout. All vectors have the layout's size, and room for kMostStates values.
class StepOperator {
 public:
  static constexpr int kNavigation = 9;
  static constexpr int kLanes = 12;  ///< columns that go through a step together: the navigation errors, and λ
  static constexpr int kLambda = kNavigation;  ///< the lane of λ
  /// Errors side by side: value of the error k in lane l at [k * lanes + l].
  using Lanes = std::array<double, static_cast<std::size_t>(kMostStates* kLanes)>;

  /// The factors of one step.
  struct Factors {
    double first, second, input;  ///< dt, ½ dt², and what B is multiplied by in first order
    Matrix3d R, C, gradient;
    Vector3d v;
    Vector3d of_imu[2], noise[2];           ///< −(1 + s)⁻¹ and noise / dt, of gyroscopes and accelerometers
    std::array<double, kSignalCount> acts;  ///< ω, f and 1: what errors of the IMU are multiplied by
    std::array<double, kBlocks.size()> decay, variance;  ///< of the blocks that are processes, in their order
    std::vector<double> across;                          ///< how scales of several IMUs act: of each Across
  };
  /// The contribution of the noise of a step to a smoothed error: Q λ, through the inputs and for each process.
  using Pull = std::array<double, static_cast<std::size_t>(6 + kMostStates)>;

  StepOperator(const StateLayout& layout, const FilterOptions& options, Vector3d earth_rate);

  int size() const { return n_; }
  void load(const ErrorStep& step, Factors& factors) const;
  /// The step as matrices, with its processes.
  Transition transition(const ErrorStep& step) const;

  /// M ← Φᵀ M of all lanes, and `pull` that of λ, which is in the lane kLambda.
  void adjoint(const Factors& f, Lanes& M, Pull& pull) const;
  /// The same for λ alone, which is in the first of four lanes.
  void adjoint_lambda(const Factors& f, Lanes& M, Pull& pull) const;
  /// e ← Φ e, less `pull` if there is one.
  void forward(const Factors& f, ErrorVector& e, const Pull* pull) const;
  /// The factor over a step of a block that does not depend on others.
  double decay(const Factors& f, int k) const {
    return states_[static_cast<std::size_t>(k)].process < 0
               ? 1
               : f.decay[static_cast<std::size_t>(states_[static_cast<std::size_t>(k)].process)];
  }

  /// One error beyond navigation.
  struct State {
    int input = -1, acts = 0;  ///< which input it adds to (−1: none), and which of Factors::acts it is multiplied by
    int process = -1;          ///< −1: constant
    double weight = 1;         ///< of the process
  };
  /// A scale of several IMUs that adds to an input, by Factors::across.
  struct Across {
    int state, input;
  };

 private:
  const StateLayout& layout_;
  const FilterOptions& options_;
  Vector3d earth_rate_;
  int n_;
  std::array<State, static_cast<std::size_t>(kMostStates)> states_;
  std::vector<DriftProcess> processes_;
  std::shared_ptr<const ImuScales> imu_scales_;
  std::vector<Across> across_;
};

}  // namespace piste
