#pragma once
/// A measurement against its prediction: residual = measured − predicted ≈ Σ J_b error_b + noise.

#include <array>

#include "piste/core/estimate.h"

namespace piste {

/// Three rows at most. Blocks that are not listed have no influence. `rows` may be fewer than three: the rest of
/// residual, covariance and Jacobians is then unused.
struct Linearization {
  struct Term {
    Block block;
    Matrix3d jacobian;  ///< rows × size of the block, in its upper left corner
  };

  int rows = 3;
  Block observes = Block::kPosition;  ///< what it measures above all
  Vector3d residual = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();

  void add(Block block, const Matrix3d& jacobian) { terms_[static_cast<std::size_t>(count_++)] = {block, jacobian}; }
  int count() const { return count_; }
  const Term& term(int i) const { return terms_[static_cast<std::size_t>(i)]; }

 private:
  std::array<Term, 12> terms_;
  int count_ = 0;
};

/// Jacobian rows (3 × layout size) for the blocks that this run estimates; the others are held as known. The only
/// place that knows. Rows beyond `rows` are zero.
using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kFullSize>;
Jacobian assemble(const StateLayout& layout, const Linearization& lin);

/// Rate and specific force of the body at the instant of a measurement, corrected, body axes.
struct BodyMotion {
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();
  Vector3d rate_variance = Vector3d::Zero();  ///< of the gyro's white noise in that rate
};

}  // namespace piste
