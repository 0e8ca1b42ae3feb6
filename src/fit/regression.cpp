#include "piste/fit/regression.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

using Extended = long double;
using ExtendedMatrix = Eigen::Matrix<Extended, Eigen::Dynamic, Eigen::Dynamic>;
using ExtendedVector = Eigen::Matrix<Extended, Eigen::Dynamic, 1>;
using Eigen::Index;

constexpr Extended kDependent = 1e-13L;  // part of a column's length beyond the columns before it; below: dependent
constexpr Index kAverages = 12;          // ν, as Mueller and Watson 2008 have it

// A of the scores u_t, the rows of U, from `count` cosine averages: S = A Aᵀ.
Eigen::MatrixXd cosine_averages(const Eigen::MatrixXd& U, Index count) {
  const Index n = U.rows();
  Eigen::MatrixXd averages = Eigen::MatrixXd::Zero(U.cols(), count);
  for (Index j = 0; j < count; ++j) {
    const double step = std::numbers::pi * static_cast<double>(j + 1) / static_cast<double>(n);
    for (Index t = 0; t < n; ++t)
      averages.col(j) += std::cos(step * (static_cast<double>(t) + 0.5)) * U.row(t).transpose();
  }
  return std::sqrt(2 / static_cast<double>(count)) * averages;
}

// Degrees of freedom of the total error. A systematic error has infinitely many; the result is limited to kMost.
double total_dof(const Term& t) {
  constexpr double kMost = 1e6;
  const double share = t.standard_error / t.total();
  return std::min(kMost, t.dof / square(square(share)));
}

// The uncertainty of coefficients whose error is C Σ q_t e_t, with orthonormal columns q.
Regression conclude(const Eigen::VectorXd& value, const Eigen::VectorXd& errors, const Eigen::MatrixXd& Q,
                    const Eigen::MatrixXd& C) {
  const Index n = Q.rows(), p = Q.cols();
  const auto samples = static_cast<double>(n), n_p = static_cast<double>(n - p);
  Regression out;
  out.samples = static_cast<int>(n);
  out.value = value;
  const double variance = errors.squaredNorm() / n_p;
  out.residual = std::sqrt(variance);
  out.covariance = variance * C * C.transpose();
  const Index count = std::clamp<Index>(n - p, 1, kAverages);
  out.averages = std::sqrt(samples / n_p) * C * cosine_averages(errors.asDiagonal() * Q, count);
  out.hac_covariance = out.averages * out.averages.transpose();
  out.dof = static_cast<double>(count);
  return out;
}

// Solves Y = X u + e for each column of Y, and returns c = T u. `length`: the lengths of the columns to which the
// coefficients c belong.
std::vector<Regression> solve(const ExtendedMatrix& X, const Eigen::MatrixXd& Y, const ExtendedMatrix& T,
                              const ExtendedVector& length) {
  const Index p = X.cols();
  const ExtendedVector own_length = X.colwise().norm();
  for (Index j = 0; j < p; ++j) {
    if (!(own_length(j) > 0)) throw DataError("regression", fmt::format("column {} is zero", j));
  }
  const Eigen::HouseholderQR<ExtendedMatrix> qr(X * own_length.cwiseInverse().asDiagonal());
  const ExtendedMatrix R = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  for (Index j = 0; j < p; ++j) {
    if (!(std::abs(R(j, j)) > kDependent)) {
      throw DataError("regression", fmt::format("column {} follows from those before it", j));
    }
  }
  const ExtendedMatrix R_inverse = R.triangularView<Eigen::Upper>().solve(ExtendedMatrix::Identity(p, p));
  const ExtendedMatrix spread = own_length.cwiseInverse().asDiagonal() * R_inverse;  // spread · spreadᵀ = (XᵀX)⁻¹
  const ExtendedMatrix turned = qr.householderQ().adjoint() * Y.cast<Extended>();
  const ExtendedMatrix found = spread * turned.topRows(p), values = T * found;
  const ExtendedMatrix errors = Y.cast<Extended>() - X * found;
  // With orthonormal columns all scores have the same unit and similar size.
  const ExtendedMatrix Q = X * spread, C = T * spread;
  const Eigen::VectorXd inflation = C.rowwise().squaredNorm().cwiseProduct(length.cwiseAbs2()).cast<double>();
  std::vector<Regression> out;
  for (Index k = 0; k < Y.cols(); ++k) {
    out.push_back(
        conclude(values.col(k).cast<double>(), errors.col(k).cast<double>(), Q.cast<double>(), C.cast<double>()));
    out.back().inflation = inflation;
  }
  return out;
}

}  // namespace

double Term::total() const { return std::hypot(standard_error, systematic); }

double Term::p_value(double hypothesis) const {
  const double distance = std::abs(value - hypothesis);
  if (total() == 0) return distance == 0 ? 1 : 0;
  return student_two_sided(distance / total(), total_dof(*this));
}

double Term::half_width(double probability) const {
  return total() == 0 ? 0 : total() * student_quantile(0.5 + 0.5 * probability, total_dof(*this));
}

Term Regression::term(int i) const {
  return {.value = value(i),
          .sigma = std::sqrt(covariance(i, i)),
          .standard_error = std::sqrt(hac_covariance(i, i)),
          .dof = dof,
          .averages = averages.size() > 0 ? Eigen::VectorXd(averages.row(i).transpose()) : Eigen::VectorXd()};
}

double Regression::correlation(int i, int j) const {
  return covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
}

double Regression::effective_samples(int i) const {
  return hac_covariance(i, i) > 0 ? samples * covariance(i, i) / hac_covariance(i, i) : samples;
}

std::vector<Regression> regress_each(const Eigen::MatrixXd& X, const Eigen::MatrixXd& Y) {
  const ExtendedMatrix wide = X.cast<Extended>();
  return solve(wide, Y, ExtendedMatrix::Identity(X.cols(), X.cols()), wide.colwise().norm());
}

Regression regress(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) { return regress_each(X, y).front(); }

Regression regress_polynomial(const Eigen::VectorXd& x, const Eigen::VectorXd& y, int order) {
  const ExtendedVector wide = x.cast<Extended>();
  const Extended mean = wide.mean();
  const ExtendedVector centred = wide.array() - mean;
  const Extended deviation = centred.norm() / std::sqrt(static_cast<Extended>(x.size()));
  if (order > 0 && !(deviation > kDependent * std::abs(mean))) throw DataError("regression", "x does not change");
  const Index p = order + 1;
  ExtendedMatrix U(x.size(), p), T = ExtendedMatrix::Zero(p, p);
  ExtendedVector length(p), power = ExtendedVector::Ones(x.size());
  U.col(0).setOnes();
  T(0, 0) = 1;
  for (Index k = 0; k < p; ++k) {
    length(k) = power.norm();
    power = power.cwiseProduct(wide);
    if (k == 0) continue;
    U.col(k) = U.col(k - 1).cwiseProduct(centred) / deviation;
    T.col(k) = -mean / deviation * T.col(k - 1);  // one more factor (x − mean) / deviation
    T.col(k).tail(p - 1) += T.col(k - 1).head(p - 1) / deviation;
  }
  return solve(U, y, T, length).front();
}

Regression regress_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y) { return regress_polynomial(x, y, 1); }

Regression regress_mean(const Eigen::VectorXd& y) { return regress(Eigen::VectorXd::Ones(y.size()), y); }

Regression regress_both_noisy(const Eigen::VectorXd& x, const Eigen::VectorXd& y, double ratio) {
  const Index n = x.size();
  const double x_mean = x.mean(), y_mean = y.mean();
  const Eigen::VectorXd dx = x.array() - x_mean, dy = y.array() - y_mean;
  const double xx = dx.squaredNorm(), xy = dx.dot(dy), yy = dy.squaredNorm();
  if (!(xx > 0 && yy > 0 && xy != 0)) {
    throw DataError("regression", "one of two noisy series does not follow the other");
  }
  const double gap = yy - ratio * xx, root = std::hypot(gap, 2 * std::sqrt(ratio) * xy);
  const double slope = gap > 0 ? (gap + root) / (2 * xy) : 2 * ratio * xy / (root - gap);  // neither cancels
  const Eigen::VectorXd e = dy - slope * dx, z = ratio * dx + slope * dy;
  Eigen::MatrixXd Q(n, 2);
  Q << Eigen::VectorXd::Constant(n, 1 / std::sqrt(static_cast<double>(n))), z.normalized();
  Eigen::Matrix2d C;
  C << 1 / std::sqrt(static_cast<double>(n)), 0, 0, z.norm() / (dx.dot(z) - e.dot(dy));
  C.row(0) -= x_mean * C.row(1);  // from the mean point to x = 0
  Regression out = conclude(Eigen::Vector2d(y_mean - slope * x_mean, slope), e, Q, C);
  out.inflation.setConstant(2, 1 / (1 - square(out.correlation(0, 1))));
  return out;
}

Term paired_difference(const Term& a, const Term& b) {
  constexpr double kRounding = 1e-9;  // of either term: both are the same estimate
  const auto shared = [](const Eigen::VectorXd& u, const Eigen::VectorXd& v) {
    return u.size() == v.size() && u.size() > 0;
  };
  Term out = difference(a, b);
  out.systematic = std::hypot(a.systematic, b.systematic);
  if (shared(a.effects, b.effects)) {
    const double alone = square(out.systematic) - a.effects.squaredNorm() - b.effects.squaredNorm();
    out.effects = a.effects - b.effects;
    out.systematic = std::sqrt(std::max(0.0, alone) + out.effects.squaredNorm());
  }
  if (shared(a.averages, b.averages)) {
    out.averages = a.averages - b.averages;
    const auto own = [](const Term& t) {
      return Term{.standard_error = std::sqrt(std::max(0.0, square(t.standard_error) - t.averages.squaredNorm())),
                  .dof = t.dof};
    };
    const Term both = difference(own(a), own(b)),
               all = difference(
                   both, {.standard_error = out.averages.norm(), .dof = static_cast<double>(out.averages.size())});
    out.standard_error = all.standard_error;
    out.dof = all.dof;
  }
  if (std::abs(out.value) < kRounding * std::hypot(a.total(), b.total())) out.value = 0;
  return out;
}

Term difference(const Term& a, const Term& b) {
  const double va = square(a.standard_error), vb = square(b.standard_error);
  const double spread = square(va) / a.dof + square(vb) / b.dof;
  return {.value = a.value - b.value,
          .sigma = std::hypot(a.sigma, b.sigma),
          .standard_error = std::sqrt(va + vb),
          .dof = spread > 0 ? square(va + vb) / spread : std::min(a.dof, b.dof)};
}

}  // namespace piste
