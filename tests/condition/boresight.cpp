// Boresight in closed form: exact without noise, its errors what its covariance says, and no number where the motion
// does not determine it.

#include "condition/boresight.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "piste/math/statistics.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;

constexpr double kPi = std::numbers::pi;
const Vector3d kBias(0.02, -0.01, 0.005);

struct Rates {
  std::vector<Vector3d> r, b;
};

// A swing about each axis of r, of its amplitude [rad/s], about a mean turn.
Rates rates(std::size_t count, const Vector3d& amplitude, const Quaterniond& q_rb) {
  Rates rates;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.05 * static_cast<double>(i);
    const Vector3d swing(std::sin(2.1 * t), std::sin(1.3 * t + 1), std::cos(0.7 * t));
    rates.r.emplace_back(Vector3d(0.1, 0, 0.3) + amplitude.cwiseProduct(swing));
    rates.b.emplace_back(q_rb.conjugate() * rates.r.back() + kBias);
  }
  return rates;
}

void add_noise(Rates& rates, Random& random, double sigma_r, double sigma_b) {
  for (Vector3d& w : rates.r) w += random.vector(sigma_r);
  for (Vector3d& w : rates.b) w += random.vector(sigma_b);
}

Vector3d error_of(const BoresightFromRates& found, const Quaterniond& q_rb) {
  return so3_log(q_rb * found.q_rb.conjugate());
}

bool undetermined(const BoresightFromRates& found) { return std::isinf(found.covariance.diagonal().minCoeff()); }

std::vector<Quaterniond> mountings() {
  std::vector<Quaterniond> out{Quaterniond::Identity()};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double angle : {kPi / 2, -kPi / 2, kPi, kPi - 1e-9})
      out.push_back(so3_exp(angle * Vector3d::Unit(axis)));
  }
  Random random(1);
  for (int i = 0; i < 50; ++i) out.push_back(random.rotation());
  for (int i = 0; i < 10; ++i) out.push_back(so3_exp(kPi * random.vector().normalized()));
  return out;
}

TEST(BoresightFromRates, IsExactWithoutNoise) {
  for (const Quaterniond& q_rb : mountings()) {
    const Rates w = rates(500, {0.5, 0.8, 0.3}, q_rb);
    const BoresightFromRates found = boresight_from_rates(w.r, w.b);
    EXPECT_LT(error_of(found, q_rb).norm(), 1e-13);
    EXPECT_LT((found.gyro_bias - kBias).norm(), 1e-13);
    EXPECT_LT(found.residual, 1e-13);
    EXPECT_LT(found.covariance.norm(), 1e-25);
  }
}

// Two axes are enough, but a turn and a reflection fit them alike: it must be the turn.
TEST(BoresightFromRates, IsARotationWhereTheRatesLieInAPlane) {
  Random random(2);
  for (const Quaterniond& q_rb : mountings()) {
    Rates w = rates(500, {0.5, 0, 0.3}, q_rb);
    const BoresightFromRates clean = boresight_from_rates(w.r, w.b);
    EXPECT_LT(error_of(clean, q_rb).norm(), 1e-13);
    add_noise(w, random, 0.01, 0.01);
    const BoresightFromRates found = boresight_from_rates(w.r, w.b);
    EXPECT_NEAR(found.q_rb.toRotationMatrix().determinant(), 1, 1e-12);
    EXPECT_LT(error_of(found, q_rb).norm(), 0.02);
    EXPECT_FALSE(undetermined(found));
  }
}

struct Noise {
  double r, b;
};

class Consistency : public testing::TestWithParam<Noise> {};

// Noise of r too, as large as its swing about one axis: the covariance must not take it for motion.
TEST_P(Consistency, ErrorsAreWhatTheCovarianceSays) {
  constexpr int kTrials = 400;
  Random random(3);
  double nees = 0, bias_nees = 0;
  Matrix3d shape = Matrix3d::Zero();
  for (int i = 0; i < kTrials; ++i) {
    const Quaterniond q_rb = random.rotation();
    Rates w = rates(1000, {0.5, 0.2, 0.05}, q_rb);
    add_noise(w, random, GetParam().r, GetParam().b);
    const BoresightFromRates found = boresight_from_rates(w.r, w.b);
    ASSERT_FALSE(undetermined(found));
    const Vector3d error = error_of(found, q_rb);
    const Eigen::LLT<Matrix3d> root(found.covariance);
    const Vector3d whitened = root.matrixL().solve(error);
    nees += whitened.squaredNorm();
    shape += whitened * whitened.transpose() / kTrials;
    // Of the bias: the noise of the means, and the mean turn through the error of the rotation.
    const Vector3d mean_r(0.1, 0, 0.3);
    const double variance = (GetParam().r * GetParam().r + GetParam().b * GetParam().b) / 1000;
    const Matrix3d J = q_rb.conjugate().toRotationMatrix() * skew(mean_r);
    const Matrix3d P = variance * Matrix3d::Identity() + J * found.covariance * J.transpose();
    const Vector3d bias = found.gyro_bias - kBias;
    bias_nees += bias.dot(P.llt().solve(bias));
  }
  const Band band = chi_squared_band(0.999, 3, kTrials);
  EXPECT_TRUE(band.contains(nees / (3 * kTrials))) << nees / (3 * kTrials);
  EXPECT_TRUE(band.contains(bias_nees / (3 * kTrials))) << bias_nees / (3 * kTrials);
  // No direction is worse than another: entries of a sample covariance of 400.
  EXPECT_LT((shape - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 4 * std::sqrt(2.0 / kTrials));
}

INSTANTIATE_TEST_SUITE_P(Noises, Consistency, testing::Values(Noise{0, 0.02}, Noise{0.05, 0.05}, Noise{0.1, 0.01}));

TEST(BoresightFromRates, SaysThatATurnAboutOneAxisDoesNotDetermineIt) {
  Random random(4);
  for (const Quaterniond& q_rb : mountings()) {
    for (int axis = 0; axis < 3; ++axis) {
      Rates w = rates(1000, Vector3d::Unit(axis), q_rb);
      EXPECT_TRUE(undetermined(boresight_from_rates(w.r, w.b)));
      add_noise(w, random, 0.02, 0.02);
      EXPECT_TRUE(undetermined(boresight_from_rates(w.r, w.b)));
    }
    Rates still = rates(1000, Vector3d::Zero(), q_rb);
    EXPECT_TRUE(undetermined(boresight_from_rates(still.r, still.b)));
    add_noise(still, random, 0.01, 0.02);
    EXPECT_TRUE(undetermined(boresight_from_rates(still.r, still.b)));
  }
}

}  // namespace
}  // namespace piste
