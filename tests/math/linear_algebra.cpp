#include "math/linear_algebra.h"

#include <gtest/gtest.h>

#include "support/random.h"

namespace piste {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Random;

constexpr double kRounding = 1e-12;

// Relative to the second.
double distance(const MatrixXd& a, const MatrixXd& b) { return (a - b).norm() / b.norm(); }

TEST(LinearAlgebra, SolvesWithASymmetricMatrix) {
  Random random(1);
  for (const int n : {1, 2, 5, 20}) {
    const MatrixXd P = random.covariance(n), X = random.matrix(n, 3);
    EXPECT_LT(distance(solve_symmetric(P, MatrixXd(P * X)), X), kRounding) << n;
    EXPECT_LT(distance(solve_symmetric(P, VectorXd(P * X.col(0))), X.col(0)), kRounding) << n;
    MatrixXd lower = P.triangularView<Eigen::Lower>();
    EXPECT_LT(distance(solve_symmetric(lower, MatrixXd(P * X)), X), kRounding) << n;
  }
}

TEST(LinearAlgebra, LeavesResidualsOrthogonalToTheColumns) {
  Random random(2);
  const MatrixXd A = random.matrix(30, 4), B = random.matrix(30, 2);
  const MatrixXd X = least_squares(A, B);
  EXPECT_LT((A.transpose() * (A * X - B)).norm(), kRounding * A.norm() * B.norm());
}

TEST(LinearAlgebra, InvertsAMatrixThatIsNotSymmetric) {
  Random random(3);
  for (const int n : {1, 3, 7}) {
    const MatrixXd A = random.matrix(n, n);
    EXPECT_LT(distance(inverse(A) * A, MatrixXd::Identity(n, n)), 1e-10) << n;
  }
}

TEST(LinearAlgebra, SingularValuesMakeTheMatrixAgain) {
  Random random(4);
  for (const int n : {1, 3, 6}) {
    const MatrixXd A = random.matrix(n, n), one = MatrixXd::Identity(n, n);
    const SingularValues svd = singular_values(A);
    EXPECT_LT(distance(svd.U * svd.values.asDiagonal() * svd.V.transpose(), A), kRounding) << n;
    EXPECT_LT(distance(svd.U.transpose() * svd.U, one), kRounding) << n;
    EXPECT_LT(distance(svd.V.transpose() * svd.V, one), kRounding) << n;
    EXPECT_GE(svd.values(n - 1), 0) << n;
    for (int i = 1; i < n; ++i) EXPECT_LE(svd.values(i), svd.values(i - 1)) << n;
  }
}

TEST(LinearAlgebra, EigenvaluesRiseAndVectorsAreOrthonormal) {
  Random random(5);
  for (const int n : {1, 3, 20}) {
    const MatrixXd P = random.covariance(n);
    const Eigensystem found = eigensystem(P);
    EXPECT_LT(distance(found.vectors * found.values.asDiagonal(), P * found.vectors), kRounding) << n;
    EXPECT_LT(distance(found.vectors.transpose() * found.vectors, MatrixXd::Identity(n, n)), kRounding) << n;
    for (int i = 1; i < n; ++i) EXPECT_GE(found.values(i), found.values(i - 1)) << n;
  }
}

TEST(LinearAlgebra, EigenvaluesOfOneMatrixAgainstAnother) {
  Random random(6);
  for (const int n : {1, 3, 12}) {
    const MatrixXd A = random.covariance(n), B = random.covariance(n);
    const Eigensystem found = eigensystem(A, B);
    EXPECT_LT(distance(A * found.vectors, B * found.vectors * found.values.asDiagonal()), 1e-11) << n;
    EXPECT_LT(distance(found.vectors.transpose() * B * found.vectors, MatrixXd::Identity(n, n)), 1e-11) << n;
    for (int i = 1; i < n; ++i) EXPECT_GE(found.values(i), found.values(i - 1)) << n;
  }
}

}  // namespace
}  // namespace piste
