// Products and eliminations of small square matrices, against Eigen's.

#include "math/square.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "support/random.h"

namespace piste {
namespace {

using Eigen::MatrixXd;

// Sizes that are no multiple of four or eight have a tile that was there before.
TEST(Square, ProductOfEverySize) {
  test::Random random(1);
  for (Eigen::Index n = 4; n <= 30; ++n) {
    const Square A = random.matrix(n, n), B = random.matrix(n, n);
    Square product(n, n);
    set_product(A, B, product);
    EXPECT_LT((product - MatrixXd(MatrixXd(A) * MatrixXd(B))).cwiseAbs().maxCoeff(), 1e-13) << n;
  }
}

TEST(Square, EliminationLeavesTheCovarianceForGivenFirstRows) {
  test::Random random(3);
  constexpr Eigen::Index kSize = 14, kFirst = 5, kRest = kSize - kFirst;
  const MatrixXd P = random.covariance(kSize);
  MatrixXd C = P;
  eliminate_first(C.data(), kSize, kFirst);
  const MatrixXd given =
      P.bottomRightCorner(kRest, kRest) -
      P.bottomLeftCorner(kRest, kFirst) * P.topLeftCorner(kFirst, kFirst).llt().solve(P.topRightCorner(kFirst, kRest));
  const MatrixXd left = C.bottomRightCorner(kRest, kRest).selfadjointView<Eigen::Lower>();
  EXPECT_LT((left - given).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Square, HoldLeavesTheThreeAndTakesTheirPartFromTheOthers) {
  test::Random random(4);
  const Square P = random.covariance(12);
  Square held = P;
  hold(held, 6);
  EXPECT_LT((held.block<3, 3>(6, 6) - P.block<3, 3>(6, 6)).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_EQ((held.block<6, 3>(0, 6).cwiseAbs().maxCoeff()), 0);
  const MatrixXd given =
      P.topLeftCorner<6, 6>() - P.block<6, 3>(0, 6) * P.block<3, 3>(6, 6).inverse() * P.block<3, 6>(6, 0);
  EXPECT_LT((MatrixXd(held.topLeftCorner<6, 6>()) - given).cwiseAbs().maxCoeff(), 1e-13);
}

}  // namespace
}  // namespace piste
