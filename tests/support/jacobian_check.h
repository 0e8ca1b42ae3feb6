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
  std::array<Matrix3d, kBlocks.size()> claimed;
  claimed.fill(Matrix3d::Zero());
  double largest = 0;
  for (int i = 0; i < lin.count(); ++i) {
    const auto& [block, jacobian] = lin.term(i);
    Matrix3d& J = claimed[static_cast<std::size_t>(index_of(block))];
    ASSERT_TRUE(J.isZero(0)) << info(block).name << " stands twice";
    J.topLeftCorner(lin.rows, info(block).size) = jacobian.topLeftCorner(lin.rows, info(block).size);
    ASSERT_TRUE(J.allFinite()) << info(block).name;
    largest = std::max(largest, J.cwiseAbs().maxCoeff());
  }
  ASSERT_GT(largest, 0);
  for (const BlockInfo& row : kBlocks) {
    Matrix3d numeric = Matrix3d::Zero();
    for (int k = 0; k < row.size; ++k) {
      constexpr double h = 1e-3;
      const auto at = [&](double step) -> Vector3d {
        return model(boxplus(x, step * FullError::Unit(full_offset(row.block) + k))).residual;
      };
      const Vector3d slope = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
      numeric.col(k).head(lin.rows) = -slope.head(lin.rows);
    }
    const Matrix3d& J = claimed[static_cast<std::size_t>(index_of(row.block))];
    const double size = std::max(J.cwiseAbs().maxCoeff(), numeric.cwiseAbs().maxCoeff());
    EXPECT_LE((J - numeric).cwiseAbs().maxCoeff(), 1e-8 * size + 1e-10 * largest) << row.name << ", claimed:\n"
                                                                                  << J << "\nby differences:\n"
                                                                                  << numeric;
  }
}

}  // namespace piste::test
