#include "math/wahba.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <vector>

#include "support/random.h"

namespace piste {
namespace {

using test::Random;

struct Vectors {
  std::vector<Vector3d> a, b;
  Matrix3d B() const {
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t i = 0; i < a.size(); ++i) sum += b[i] * a[i].transpose();
    return sum;
  }
  double cost(const Matrix3d& R) const {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (b[i] - R * a[i]).squaredNorm();
    return sum;
  }
};

Vectors turned(const Matrix3d& R, double noise, Random& random) {
  Vectors v;
  for (int i = 0; i < 12; ++i) {
    v.a.push_back(random.vector(1));
    v.b.emplace_back(R * v.a.back() + random.vector(noise));
  }
  return v;
}

TEST(Wahba, FindsTheRotationThatWasUsed) {
  Random random(1);
  for (const double hand : {1.0, -1.0}) {
    const Matrix3d R = hand * random.rotation().toRotationMatrix();
    EXPECT_LT((solve_wahba(turned(R, 0, random).B(), hand < 0).R - R).norm(), 1e-13);
  }
}

TEST(Wahba, IsAMinimumAndARotation) {
  Random random(2);
  for (int run = 0; run < 20; ++run) {
    // Noise as large as the vectors, so that the best orthogonal matrix is often of the other handedness.
    const Vectors v = turned(random.rotation().toRotationMatrix(), 2, random);
    for (const bool mirrored : {false, true}) {
      const WahbaSolution found = solve_wahba(v.B(), mirrored);
      EXPECT_NEAR(found.R.determinant(), mirrored ? -1 : 1, 1e-12);
      EXPECT_NEAR(found.alignment(), (found.R.transpose() * v.B()).trace(), 1e-11);
      for (int i = 0; i < 20; ++i) {
        EXPECT_GE(v.cost(so3_exp(random.vector(0.3)) * found.R), v.cost(found.R) - 1e-11);
      }
    }
  }
}

TEST(Wahba, InformationIsTheCurvatureOfTheCost) {
  Random random(3);
  const Vectors v = turned(random.rotation().toRotationMatrix(), 0.3, random);
  const WahbaSolution found = solve_wahba(v.B());
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 3; ++i) {
    const Vector3d step = kStep * found.axes.col(i);
    const double bend = v.cost(so3_exp(step) * found.R) - 2 * v.cost(found.R) + v.cost(so3_exp(-step) * found.R);
    EXPECT_NEAR(bend / (2 * kStep * kStep), found.information()(i), 1e-5 * found.information().z());
  }
}

}  // namespace
}  // namespace piste
