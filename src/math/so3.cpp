#include "piste/math/so3.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace piste {
namespace {

// sin(x)/x, (1−cos x)/x², (x−sin x)/x³ as functions of x², by series where the closed form cancels.
struct Coefficients {
  double a, b, c;
};

Coefficients coefficients(double x2) {
  if (x2 < 1e-2) {
    return {1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72))),
            0.5 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56 * (1 - x2 / 90)))),
            (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72 * (1 - x2 / 110)))) / 6};
  }
  const double x = std::sqrt(x2);
  const double half = std::sin(0.5 * x);  // 1 − cos x = 2 sin²(x/2), which does not cancel
  return {std::sin(x) / x, 2 * half * half / x2, (x - std::sin(x)) / (x2 * x)};
}

// (x²/2 + cos x − 1)/x⁴ and (sin x − x + x³/6)/x⁵.
struct HigherCoefficients {
  double d, e;
};

HigherCoefficients higher_coefficients(double x2) {
  if (x2 < 1) {
    double d = 0, e = 0;  // by their series, from its end
#pragma GCC unroll 9
    for (int k = 9; k > 0; --k) {
      d = (1 - d) * x2 * (1.0 / ((2 * k + 3) * (2 * k + 4)));
      e = (1 - e) * x2 * (1.0 / ((2 * k + 4) * (2 * k + 5)));
    }
    return {(1 - d) / 24, (1 - e) / 120};
  }
  const double x = std::sqrt(x2);
  return {(x2 / 2 + std::cos(x) - 1) / (x2 * x2), (std::sin(x) - x + x * x2 / 6) / (x2 * x2 * x)};
}

}  // namespace

Quaterniond so3_exp(const Vector3d& rotation_vector) {
  const double x2 = rotation_vector.squaredNorm() / 4;  // of half the angle
  double sinc, cosine;
  if (x2 < 1e-2) {
    sinc = 1 - x2 * (1.0 / 6) * (1 - x2 * (1.0 / 20) * (1 - x2 * (1.0 / 42) * (1 - x2 * (1.0 / 72))));
    cosine = 1 - x2 * (1.0 / 2) *
                     (1 - x2 * (1.0 / 12) * (1 - x2 * (1.0 / 30) * (1 - x2 * (1.0 / 56) * (1 - x2 * (1.0 / 90)))));
  } else {
    const double x = std::sqrt(x2);
    sinc = std::sin(x) / x;
    cosine = std::cos(x);
  }
  const Vector3d v = 0.5 * sinc * rotation_vector;
  return {cosine, v.x(), v.y(), v.z()};
}

Vector3d so3_log(const Quaterniond& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const Vector3d v = sign * q.vec();
  const double s = v.norm(), w = sign * q.w();
  // atan2 keeps full precision at both ends; below 1e-8 the ratio 2 asin(s)/s is 2 to rounding.
  const double ratio = s < 1e-8 ? 2.0 / w : 2.0 * std::atan2(s, w) / s;
  return ratio * v;
}

Quaterniond rotation_between(const Vector3d& a, const Vector3d& b) {
  constexpr double kOpposite = 1e-12;
  const Vector3d from = a.normalized(), to = b.normalized();
  const double cosine = to.dot(from);
  if (cosine < kOpposite - 1) {
    const double w2 = 0.5 * (1 + std::max(cosine, -1.0));
    const Vector3d v = std::sqrt(1 - w2) * from.unitOrthogonal();
    return {std::sqrt(w2), v.x(), v.y(), v.z()};
  }
  const double twice_w = std::sqrt(2 * (1 + cosine));
  const Vector3d v = from.cross(to) * (1 / twice_w);
  return {0.5 * twice_w, v.x(), v.y(), v.z()};
}

Matrix3d so3_left_jacobian(const Vector3d& rotation_vector) {
  const auto k = coefficients(rotation_vector.squaredNorm());
  const Matrix3d S = skew(rotation_vector);
  return Matrix3d::Identity() + k.b * S + k.c * S * S;
}

Matrix3d se3_left_jacobian_shift(const Vector3d& nu, const Vector3d& rotation_vector) {
  const Vector3d& phi = rotation_vector;
  const double x2 = phi.squaredNorm(), along = phi.dot(nu), c = coefficients(x2).c;
  const auto [d, e] = higher_coefficients(x2);
  // The products of [phi] and [nu] by [a] [b] = b aᵀ − a·b, [phi] [nu] [phi] = −(phi·nu) [phi].
  const Matrix3d both = nu * phi.transpose();
  Matrix3d Q = c * (both + both.transpose()) - along * (d - 3 * e) * phi * phi.transpose();
  Q.diagonal().array() += along * (x2 * (d - 3 * e) - 2 * c);
  return Q + skew(0.5 * nu + along * (d - c) * phi + d * phi.cross(phi.cross(nu)));
}

Matrix3d so3_left_jacobian_inverse(const Vector3d& rotation_vector) {
  const double x2 = rotation_vector.squaredNorm();
  const Matrix3d S = skew(rotation_vector);
  const auto k = coefficients(x2);
  // (1 − a/(2b))/x²; near 0 its series, 1/12 (1 + x²/60 + …).
  const double d = x2 < 1e-2 ? (1 + x2 / 60 * (1 + x2 / 42 * (1 + x2 / 40))) / 12 : (1 - 0.5 * k.a / k.b) / x2;
  return Matrix3d::Identity() - 0.5 * S + d * S * S;
}

Quaterniond from_euler(const Vector3d& e) {
  return Quaterniond(Eigen::AngleAxisd(e.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(e.y(), Vector3d::UnitY()) *
                     Eigen::AngleAxisd(e.x(), Vector3d::UnitX()));
}

namespace {

constexpr double kUpright = 1e-12;  // cosine of the pitch below which roll and heading cannot be separated

// The entries are at most 1: no need for hypot's care.
double cos_pitch(const Matrix3d& R) { return std::sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0)); }

}  // namespace

Vector3d to_euler(const Quaterniond& q) { return to_euler(q.toRotationMatrix()); }

Vector3d to_euler(const Matrix3d& R) {
  const double cosine = cos_pitch(R), pitch = std::atan2(-R(2, 0), cosine);
  if (cosine < kUpright) return {0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

Matrix3d euler_axes(const Vector3d& e) {
  const double sp = std::sin(e.y()), cp = std::cos(e.y()), sh = std::sin(e.z()), ch = std::cos(e.z());
  Matrix3d E;
  E << cp * ch, -sh, 0, cp * sh, ch, 0, -sp, 0, 1;
  return E;
}

Vector3d euler_sigma(const Quaterniond& q, const Matrix3d& covariance) {
  return euler_sigma(q.toRotationMatrix(), Matrix3d::Identity(), covariance);
}

Vector3d euler_sigma(const Matrix3d& R, const Matrix3d& turn, const Matrix3d& covariance) {
  const double cosine = cos_pitch(R), sp = -R(2, 0), cp = std::max(cosine, 1e-9);
  const double sh = cosine < kUpright ? -R(0, 1) : R(1, 0) / cosine;
  const double ch = cosine < kUpright ? R(1, 1) : R(0, 0) / cosine;
  Matrix3d D;  // inverse of euler_axes
  D << ch / cp, sh / cp, 0, -sh, ch, 0, sp * ch / cp, sp * sh / cp, 1;
  const Matrix3d J = D * turn;
  const Vector3d variance = (J * covariance).cwiseProduct(J).rowwise().sum();
  return variance.cwiseMax(0).cwiseSqrt().cwiseMin(std::numbers::pi);
}

}  // namespace piste
