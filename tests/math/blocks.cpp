// Products and inverses of every size, against Eigen's.

#include "math/blocks.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "support/random.h"

namespace piste {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

TEST(Blocks, ProductsOfEverySize) {
  test::Random random(1);
  for (Index rows = 1; rows <= 13; ++rows) {
    for (Index columns = 1; columns <= 9; ++columns) {
      constexpr Index kInner = 5;
      Blocks of_a(1, rows, kInner), of_b(1, kInner, columns), of_bt(1, columns, kInner), of_c(1, rows, columns);
      const MatrixXd A = random.matrix(rows, kInner), B = random.matrix(kInner, columns);
      of_a[0] = A;
      of_b[0] = B;
      of_bt[0] = B.transpose();
      set_product(of_a[0], of_b[0], of_c[0]);
      EXPECT_TRUE(of_c[0].isApprox(A * B, 1e-13)) << rows << " " << columns;
      add_product_transposed(2, of_a[0], of_bt[0], of_c[0]);
      EXPECT_TRUE(of_c[0].isApprox(3 * A * B, 1e-13)) << rows << " " << columns;
    }
  }
}

TEST(Blocks, InversesOfEverySize) {
  test::Random random(2);
  for (Index n = 1; n <= 14; ++n) {
    // Of rows whose units differ by orders of magnitude.
    const Eigen::VectorXd unit = Eigen::VectorXd::LinSpaced(n, -6, 6).array().exp();
    const MatrixXd A = unit.asDiagonal() * random.covariance(n) * unit.asDiagonal();
    Blocks blocks(1, n, n);
    blocks[0] = A;
    ASSERT_TRUE(invert_definite(blocks[0])) << n;
    EXPECT_LT((unit.asDiagonal() * (blocks[0] - A.inverse()) * unit.asDiagonal()).cwiseAbs().maxCoeff(), 1e-10) << n;
  }
}

TEST(Blocks, WhatIsNotDefiniteIsSaidToBeSo) {
  test::Random random(3);
  for (Index n = 1; n <= 9; ++n) {
    const MatrixXd root = random.matrix(n, n > 1 ? n - 1 : 1);
    for (const double spoilt : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
      Blocks blocks(1, n, n);
      blocks[0] = random.covariance(n);
      blocks[0](n / 2, n / 2) = spoilt;
      EXPECT_FALSE(invert_definite(blocks[0])) << n << " " << spoilt;
    }
    if (n == 1) continue;
    Blocks singular(1, n, n);
    singular[0] = root * root.transpose();
    singular[0].diagonal().array() -= 1e-9;
    EXPECT_FALSE(invert_definite(singular[0])) << n;
  }
}

TEST(Blocks, AreZeroInMemoryThatIsUsedAgain) {
  Blocks blocks(3, 5, 2);
  for (std::size_t i = 0; i < 3; ++i) blocks[i].setOnes();
  blocks.reset(2, 5, 2);
  EXPECT_TRUE(blocks[0].isZero(0) && blocks[1].isZero(0));
  blocks.reset(4, 5, 3);
  EXPECT_EQ(blocks.columns(), 3);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(blocks[i].isZero(0));
}

}  // namespace
}  // namespace piste
