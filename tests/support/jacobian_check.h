#pragma once
/// Compares every Jacobian of a measurement model with central differences through boxplus, for every block of the
/// table. A block that the model does not mention must have no influence.

#include <gtest/gtest.h>

#include "piste/model/measurement.h"

namespace piste::test {

/// `model`: Estimate -> Linearization. Checks residual(x ⊞ e) ≈ residual(x) − J e. Differences of fourth order with a
/// step of 1e-3 units have an error of 1e-8 of a block's Jacobian, or 1e-10 of the largest one.
template <class Model>
void check_jacobians(const Model& model, const Estimate& x) {
  const Linearization lin = model(x);
  using BlockJacobian = Eigen::Matrix<double, 3, kLargestBlock>;
  std::array<BlockJacobian, kBlocks.size()> claimed;
  claimed.fill(BlockJacobian::Zero());
  double largest = 0;
  for (int i = 0; i < lin.count(); ++i) {
    const Linearization::Term& term = lin.term(i);
    BlockJacobian& J = claimed[static_cast<std::size_t>(index_of(term.block))];
    ASSERT_TRUE(J.middleCols(term.column, term.size()).isZero(0)) << info(term.block).name << " stands twice";
    J.block(0, term.column, lin.rows, term.size()) = term.jacobian.topLeftCorner(lin.rows, term.size());
    ASSERT_TRUE(J.allFinite()) << info(term.block).name;
    largest = std::max(largest, J.cwiseAbs().maxCoeff());
  }
  ASSERT_GT(largest, 0);
  for (const BlockInfo& row : kBlocks) {
    BlockJacobian numeric = BlockJacobian::Zero();
    for (int k = 0; k < row.size; ++k) {
      constexpr double h = 1e-3;
      const auto at = [&](double step) -> Vector3d {
        return model(boxplus(x, step * FullError::Unit(full_offset(row.block) + k))).residual;
      };
      const Vector3d slope = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
      numeric.col(k).head(lin.rows) = -slope.head(lin.rows);
    }
    const BlockJacobian& J = claimed[static_cast<std::size_t>(index_of(row.block))];
    const double size = std::max(J.cwiseAbs().maxCoeff(), numeric.cwiseAbs().maxCoeff());
    EXPECT_LE((J - numeric).cwiseAbs().maxCoeff(), 1e-8 * size + 1e-10 * largest) << row.name << ", claimed:\n"
                                                                                  << J << "\nby differences:\n"
                                                                                  << numeric;
  }
}

}  // namespace piste::test
