#pragma once
// The terms of which the objective of a batch is the sum of squares: residuals, whitened, and their derivatives.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "chain.h"
#include "math/arrow_matrix.h"

namespace piste {

/// A residual, and its derivatives by the errors of one or two nodes and of the constants.
struct BatchTerm {
  Eigen::VectorXd residual;
  Eigen::MatrixXd by_first, by_second, by_constant;
};

/// What an interval says, not whitened, with rows as the errors of a node: (place, speed, turn) of the sum, then d_j −
/// e^{−βT} d_i of every process. `start` and `end` have the constants, which may differ from those of the chain.
BatchTerm compare_ends(const BatchLayout& layout, const FilterOptions& options, const ImuSum& sum,
                       const Estimate& linearised_at, const Estimate& start, const Estimate& end,
                       const Vector3d& earth_rate, const Gravity& gravity);

/// Covariance of that residual: of what the IMU's noise and the processes add in the interval.
Eigen::MatrixXd interval_noise(const BatchLayout& layout, const FilterOptions& options, const ImuSum& sum);

/// W with Wᵀ W = P⁻¹, lower triangular. Throws DataError if P is not positive definite.
Eigen::MatrixXd whitening(const Eigen::MatrixXd& P);

/// The objective: the prior at the first node, intervals and fixes of a chain. Whitening is that of the estimates of
/// the chain, so that it does not change while the objective is minimised. For the same reason a fix is linear in the
/// constants, with the derivatives at the chain: those of the models are not of the residual itself where that holds
/// the noise of the rate (MeasurementContext::rate_without_noise), and a minimum of squares would follow that noise.
class BatchTerms {
 public:
  BatchTerms(const World& world, const FilterOptions& options, const BatchLayout& layout, const Start& start,
             const Chain& chain);
  /// Takes whitening from the chain as it is now: before all else, and when it was laid anew. Linearises fixes about
  /// `states`, which are its nodes but for the constants.
  void follow_chain(const std::vector<Estimate>& states, std::size_t threads);
  /// Linearises fixes about other states.
  void linearise(const std::vector<Estimate>& states, std::size_t threads);
  /// All fixes as that has left them.
  const ArrowRows& fixes() const { return rows_; }

  /// Of these two, nodes as they are now with the constants in them.
  BatchTerm prior(const Estimate& first) const;
  BatchTerm interval(std::size_t i, const Estimate& start, const Estimate& end) const;
  BatchTerm fix(std::size_t i, const Estimate& x) const;
  /// The interval as what ties the errors of its ends, into `links`, which are zero or of these terms. Returns the
  /// square of its whitened residual. No heap.
  double tie(std::size_t i, const Estimate& start, const Estimate& end, ChainLinks& links) const;
  /// The inverse of interval_noise().
  Blocks::ConstView information(std::size_t i) const { return information_[i]; }

  const Chain& chain() const { return chain_; }
  const BatchLayout& layout() const { return layout_; }
  int rows_of_fix(std::size_t i) const { return fixes_[i].rows; }
  int source_of_fix(std::size_t i) const { return chain_.fixes[i].place.source; }

 private:
  /// First row of each block among the errors of a part, −1 if it is not in it.
  using Offsets = std::array<int, kBlocks.size()>;
  static Offsets offsets_of(const BatchLayout::Part& part);
  struct Fix {
    int rows;
    Matrix3d whitening;  // zero beyond its rows
  };
  void weigh_interval(std::size_t i, ProcessSteps& processes);
  void weigh_fix(std::size_t i, const Estimate& x);
  Linearization about(std::size_t i, const Estimate& x) const;
  void put_fix(std::size_t i, const Linearization& lin, const Estimate& x, const Blocks::View& J, Blocks::View K) const;
  void put_noise(std::size_t i, const Blocks::View& P) const;
  Linearization linearize(const ChainFix& fix, const Estimate& x) const;

  const World& world_;
  const FilterOptions& options_;
  const BatchLayout& layout_;
  const Chain& chain_;
  Offsets of_node_, of_constant_;
  Estimate start_;
  Eigen::MatrixXd prior_;  // whitening, in the order of the run's error vector
  Blocks processes_;       // of each interval, by row of a node: the decay of a value, and the variance that is added
  Blocks information_;     // of each interval
  std::vector<Fix> fixes_;
  ArrowRows rows_;  // of each fix
};

}  // namespace piste
