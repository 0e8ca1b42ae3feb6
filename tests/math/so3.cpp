#include "piste/math/so3.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "support/random.h"

namespace piste {
namespace {

using test::Random;

// Angles at which a formula may lose its digits.
constexpr double kAngles[] = {0,
                              1e-300,
                              1e-12,
                              1e-9,
                              1e-7,
                              1e-5,
                              1e-3,
                              0.05,
                              0.0999,
                              0.1001,
                              0.3,
                              1,
                              2,
                              3,
                              3.1,
                              std::numbers::pi - 1e-6,
                              std::numbers::pi - 1e-10};

TEST(So3, LogUndoesExp) {
  Random random(1);
  for (const double angle : kAngles) {
    for (int i = 0; i < 10; ++i) {
      const Vector3d phi = angle * random.vector().normalized();
      const Quaterniond q = so3_exp(phi);
      EXPECT_NEAR(q.norm(), 1, 3e-16);
      EXPECT_LE((so3_log(q) - phi).norm(), 1e-15 * std::max(angle, 1.0) + 4e-16 * angle) << angle;
      const Quaterniond other(-q.w(), -q.x(), -q.y(), -q.z());
      EXPECT_LE((so3_log(other) - phi).norm(), 2e-15 * std::max(angle, 1.0)) << angle;
    }
  }
}

TEST(So3, LogOfATinyRotationKeepsItsDigits) {
  const Vector3d phi(1e-12, -2e-12, 3e-12);
  EXPECT_LT((so3_log(so3_exp(phi)) - phi).norm(), 1e-15 * phi.norm());
}

TEST(So3, RotationBetweenTurnsOneDirectionIntoTheOther) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = random.vector(20), b = random.vector(0.1);
    const Quaterniond q = rotation_between(a, b);
    EXPECT_NEAR(q.norm(), 1, 1e-14);
    EXPECT_LT((q * a.normalized() - b.normalized()).norm(), 1e-14);
    EXPECT_NEAR(so3_log(q).norm(), std::atan2(a.cross(b).norm(), a.dot(b)), 1e-13);  // and by no longer way
  }
}

TEST(So3, RotationBetweenOppositeDirectionsIsAHalfTurn) {
  for (const Vector3d& a : {Vector3d(0, 0, 9.8), Vector3d(1, 0, 0), Vector3d(-1, 2, 3)}) {
    const Quaterniond q = rotation_between(a, -a);
    EXPECT_NEAR(q.norm(), 1, 1e-14);
    EXPECT_LT((q * a + a).norm(), 1e-14 * a.norm());
  }
  EXPECT_LT((rotation_between({1, 2, 3}, {1, 2, 3}).coeffs() - Quaterniond::Identity().coeffs()).norm(), 1e-15);
}

TEST(So3, LogIsAtMostPi) {
  Random random(2);
  for (int i = 0; i < 100; ++i) EXPECT_LE(so3_log(random.rotation()).norm(), std::numbers::pi + 1e-15);
  EXPECT_NEAR(so3_log(Quaterniond(0, 0, 1, 0)).norm(), std::numbers::pi, 1e-15);
  // Beyond π it goes the other way round.
  EXPECT_LT((so3_log(so3_exp(Vector3d(std::numbers::pi + 0.1, 0, 0))) + Vector3d(std::numbers::pi - 0.1, 0, 0)).norm(),
            1e-15);
}

TEST(So3, ExpIsTheRotationAboutTheAxis) {
  EXPECT_LT((so3_exp({0, 0, std::numbers::pi / 2}) * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
  Random random(3);
  const Vector3d phi = random.vector();
  const Matrix3d expected = Eigen::AngleAxisd(phi.norm(), phi.normalized()).toRotationMatrix();
  EXPECT_LT((so3_exp(phi).toRotationMatrix() - expected).norm(), 1e-15);
}

TEST(So3, LeftJacobianIsTheDerivativeOfExp) {
  Random random(4);
  for (const double angle : kAngles) {
    const Vector3d phi = angle * random.vector().normalized();
    Matrix3d numeric;
    constexpr double h = 1e-3;
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](double step) -> Vector3d {
        return so3_log(so3_exp(phi + step * Vector3d::Unit(k)) * so3_exp(phi).conjugate());
      };
      numeric.col(k) = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
    }
    EXPECT_LT((so3_left_jacobian(phi) - numeric).norm(), 1e-11) << angle;
  }
}

TEST(So3, ShiftOfTheLeftJacobianIsItsSeries) {
  Random random(7);
  for (const double angle : kAngles) {
    const Vector3d phi = angle * random.vector().normalized(), nu = random.vector(3);
    const Matrix3d P = skew(phi), N = skew(nu);
    Matrix3d A = Matrix3d::Identity(), B = Matrix3d::Zero(), sum = B;  // ad^n / (n+1)! = (A B; 0 A)
    for (int n = 1; n <= 60; ++n) {
      B = ((A * N + B * P) / (n + 1)).eval();
      A = (A * P / (n + 1)).eval();
      sum += B;
    }
    EXPECT_LT((se3_left_jacobian_shift(nu, phi) - sum).norm(), 3e-14 * (1 + nu.norm())) << angle;
  }
}

TEST(So3, InverseOfTheLeftJacobianIsItsInverse) {
  Random random(5);
  for (const double angle : kAngles) {
    const Vector3d phi = angle * random.vector().normalized();
    const Matrix3d product = so3_left_jacobian(phi) * so3_left_jacobian_inverse(phi);
    EXPECT_LT((product - Matrix3d::Identity()).norm(), 1e-14) << angle;
  }
}

// Both sides of the switch from series to closed form.
TEST(So3, JacobianIsSmoothAcrossItsSeries) {
  const Vector3d axis = Vector3d(1, 2, -2) / 3;
  const Vector3d below = (0.1 - 1e-13) * axis, above = (0.1 + 1e-13) * axis;
  EXPECT_LT((so3_left_jacobian(below) - so3_left_jacobian(above)).norm(), 1e-12);
  EXPECT_LT((so3_left_jacobian_inverse(below) - so3_left_jacobian_inverse(above)).norm(), 1e-11);
}

TEST(Euler, AnglesComeBack) {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Vector3d e(std::numbers::pi * (2 * random.uniform() - 1), std::numbers::pi * (random.uniform() - 0.5) * 0.999,
                     std::numbers::pi * (2 * random.uniform() - 1));
    EXPECT_LT((to_euler(from_euler(e)) - e).norm(), 1e-11);
  }
}

TEST(Euler, SequenceIsHeadingPitchRoll) {
  const Vector3d e(0.1, -0.4, 2);
  const Quaterniond expected = so3_exp({0, 0, e.z()}) * so3_exp({0, e.y(), 0}) * so3_exp({e.x(), 0, 0});
  EXPECT_LT(from_euler(e).angularDistance(expected), 1e-15);
  // Nose up lifts the forward axis: its down component is negative.
  EXPECT_LT((from_euler({0, 0.3, 0}) * Vector3d::UnitX()).z(), 0);
}

TEST(Euler, StraightUpKeepsTheRotation) {
  for (const double pitch : {std::numbers::pi / 2, -std::numbers::pi / 2}) {
    const Quaterniond q = from_euler({0.3, pitch, 1.1});
    const Vector3d e = to_euler(q);
    EXPECT_NEAR(e.y(), pitch, 1e-7);
    EXPECT_LT(from_euler(e).angularDistance(q), 1e-7);
  }
}

TEST(Euler, AxesAreTheDerivative) {
  Random random(7);
  for (int i = 0; i < 20; ++i) {
    const Vector3d e(3 * random.gaussian(), random.uniform() - 0.5, 3 * random.gaussian());
    const Matrix3d E = euler_axes(e);
    for (int k = 0; k < 3; ++k) {
      constexpr double h = 1e-5;
      const Vector3d plus = e + h * Vector3d::Unit(k), minus = e - h * Vector3d::Unit(k);
      const Vector3d numeric = so3_log(from_euler(plus) * from_euler(minus).conjugate()) / (2 * h);
      EXPECT_LT((E.col(k) - numeric).norm(), 1e-9);
    }
  }
}

TEST(Euler, SigmasAreThoseOfTheAngles) {
  Random random(8);
  const Vector3d e(0.4, -0.6, 2.2);
  const Matrix3d E = euler_axes(e), P = 1e-6 * random.covariance(3);
  const Matrix3d angles = E.inverse() * P * E.inverse().transpose();
  EXPECT_LT((euler_sigma(from_euler(e), P) - angles.diagonal().cwiseSqrt()).norm(), 1e-14);
  const Vector3d up = euler_sigma(from_euler({0, std::numbers::pi / 2, 0}), P);
  EXPECT_EQ(up.x(), std::numbers::pi);
  EXPECT_EQ(up.z(), std::numbers::pi);
}

}  // namespace
}  // namespace piste
