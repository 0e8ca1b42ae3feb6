#include "piste/analyse/regression.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

using Extended = long double;
using ExtendedMatrix = Eigen::Matrix<Extended, Eigen::Dynamic, Eigen::Dynamic>;
using ExtendedVector = Eigen::Matrix<Extended, Eigen::Dynamic, 1>;
using Eigen::Index;

constexpr Extended kDependent = 1e-13L;      // of a column's length that the columns before it do not explain
constexpr double kLagFactor = 2;             // L = 2 √n
constexpr double kParzenSquared = 0.539286;  // ∫ w² from −1 to 1 = 151/280
constexpr double kPersistence = 0.97;        // largest singular value of the whitening autoregression

// A with σ(A) ≤ kPersistence, from u_t = A u_(t−1) + v_t.
Eigen::MatrixXd autoregression(const Eigen::MatrixXd& U) {
  const Index n = U.rows();
  const Eigen::MatrixXd lagged = U.topRows(n - 1).transpose() * U.topRows(n - 1);
  const Eigen::MatrixXd across = U.bottomRows(n - 1).transpose() * U.topRows(n - 1);
  const Eigen::MatrixXd A = lagged.ldlt().solve(across.transpose()).transpose();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.singularValues().cwiseMin(kPersistence).asDiagonal() * svd.matrixV().transpose();
}

// Parzen's window of x ≥ 0.
double parzen(double x) {
  const double y = 1 - x;
  return x < 0.5 ? 1 - 6 * x * x * y : 2 * y * y * y;
}

// S of scores u_t = rows of U, with Parzen's weights up to `lag`, whitened before and recoloured after.
Eigen::MatrixXd long_run(const Eigen::MatrixXd& U, Index lag) {
  const Index n = U.rows(), p = U.cols();
  const Eigen::MatrixXd A = autoregression(U);
  const Eigen::MatrixXd V = U.bottomRows(n - 1) - U.topRows(n - 1) * A.transpose();
  Eigen::MatrixXd S = V.transpose() * V;
  for (Index k = 1; k <= lag; ++k) {
    const double weight = parzen(static_cast<double>(k) / static_cast<double>(lag + 1));
    const Eigen::MatrixXd product = V.bottomRows(n - 1 - k).transpose() * V.topRows(n - 1 - k);
    S += weight * (product + product.transpose());
  }
  const Eigen::MatrixXd colour = (Eigen::MatrixXd::Identity(p, p) - A).inverse();
  return static_cast<double>(n) / static_cast<double>(n - 1) * colour * S * colour.transpose();
}

double square(double x) { return x * x; }

// A systematic error is known to as many degrees of freedom as one likes; these are enough.
double total_dof(const Term& t) {
  constexpr double kMost = 1e6;
  const double share = t.standard_error / t.total();
  return std::min(kMost, t.dof / square(square(share)));
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
  return {value(i), std::sqrt(covariance(i, i)), std::sqrt(hac_covariance(i, i)), dof};
}

double Regression::correlation(int i, int j) const {
  return covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
}

double Regression::effective_samples(int i) const {
  return hac_covariance(i, i) > 0 ? samples * covariance(i, i) / hac_covariance(i, i) : samples;
}

Regression regress(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
  const Index n = X.rows(), p = X.cols();
  const ExtendedMatrix wide = X.cast<Extended>();
  const ExtendedVector length = wide.colwise().norm();
  for (Index j = 0; j < p; ++j) {
    if (!(length(j) > 0)) throw DataError("regression", fmt::format("column {} is zero", j));
  }
  const Eigen::HouseholderQR<ExtendedMatrix> qr(wide * length.cwiseInverse().asDiagonal());
  const ExtendedMatrix R = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  for (Index j = 0; j < p; ++j) {
    if (!(std::abs(R(j, j)) > kDependent)) {
      throw DataError("regression", fmt::format("column {} follows from those before it", j));
    }
  }
  const ExtendedMatrix R_inverse = R.triangularView<Eigen::Upper>().solve(ExtendedMatrix::Identity(p, p));
  const ExtendedMatrix spread = length.cwiseInverse().asDiagonal() * R_inverse;  // spread · spreadᵀ = (XᵀX)⁻¹
  const ExtendedVector turned = qr.householderQ().adjoint() * y.cast<Extended>();
  const ExtendedVector value = spread * turned.head(p);
  const ExtendedVector residuals = y.cast<Extended>() - wide * value;
  const auto n_p = static_cast<double>(n - p);

  Regression out;
  out.samples = static_cast<int>(n);
  out.value = value.cast<double>();
  const auto variance = static_cast<double>(residuals.squaredNorm()) / n_p;
  out.residual = std::sqrt(variance);
  const ExtendedMatrix unscaled = spread * spread.transpose();
  out.covariance = variance * unscaled.cast<double>();
  out.inflation = unscaled.diagonal().cwiseProduct(length.cwiseAbs2()).cast<double>();

  // Scores of the orthonormal columns: all of one unit, and none of them drowns another.
  const ExtendedMatrix Q = wide * spread;
  const Eigen::MatrixXd scores = (residuals.asDiagonal() * Q).cast<double>();
  const auto wanted = static_cast<Index>(std::ceil(kLagFactor * std::sqrt(static_cast<double>(n))));
  const Index lag = std::clamp<Index>(n - 2, 0, wanted);
  out.lag = static_cast<int>(lag);
  const Eigen::MatrixXd to_value = spread.cast<double>();
  out.hac_covariance = static_cast<double>(n) / n_p * to_value * long_run(scores, lag) * to_value.transpose();
  const double n_window = static_cast<double>(n) / (kParzenSquared * static_cast<double>(lag + 1));
  double samples = std::min(static_cast<double>(n), n_window);
  for (int i = 0; i < p; ++i) samples = std::min(samples, out.effective_samples(i));
  out.dof = std::max(1.0, samples - static_cast<double>(p));
  return out;
}

Regression regress_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const double mean = x.mean();
  Eigen::MatrixXd X(x.size(), 2);
  X.col(0).setOnes();
  X.col(1) = x.array() - mean;
  Regression line = regress(X, y);
  const Eigen::Matrix2d T = (Eigen::Matrix2d() << 1, -mean, 0, 1).finished();  // c₀ = c at the mean − c₁ · mean
  line.value = T * line.value;
  line.covariance = T * line.covariance * T.transpose();
  line.hac_covariance = T * line.hac_covariance * T.transpose();
  line.inflation.setConstant(1 / (1 - square(line.correlation(0, 1))));
  return line;
}

Regression regress_mean(const Eigen::VectorXd& y) { return regress(Eigen::VectorXd::Ones(y.size()), y); }

Term difference(const Term& a, const Term& b) {
  const double va = square(a.standard_error), vb = square(b.standard_error);
  const double spread = square(va) / a.dof + square(vb) / b.dof;
  return {a.value - b.value, std::hypot(a.sigma, b.sigma), std::sqrt(va + vb),
          spread > 0 ? square(va + vb) / spread : std::min(a.dof, b.dof)};
}

}  // namespace piste
