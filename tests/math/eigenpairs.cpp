#include "math/eigenpairs.h"

#include <gtest/gtest.h>

#include "support/random.h"

namespace piste {
namespace {

TEST(Eigenpairs, MakeTheMatrixAgain) {
  test::Random random(4);
  for (const int n : {1, 3, 9, 30}) {
    const Square X = random.covariance(n);
    const Eigenpairs pairs = eigenpairs(X);
    EXPECT_TRUE(X.isApprox(pairs.vectors * pairs.values.asDiagonal() * pairs.vectors.transpose(), 1e-12)) << n;
    EXPECT_TRUE((pairs.vectors.transpose() * pairs.vectors).isIdentity(1e-12)) << n;
    for (int i = 1; i < n; ++i) EXPECT_LE(pairs.values(i - 1), pairs.values(i));
  }
}

}  // namespace
}  // namespace piste
