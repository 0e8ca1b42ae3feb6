#include "piste/solve/update.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace piste {
namespace {

using Tall = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kFullSize, 3>;

void symmetrize(Covariance& P) {
  for (int j = 1; j < P.cols(); ++j) {
    for (int i = 0; i < j; ++i) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
  }
}

// M ← Gᵀ M or G M on the rows that the reset touches.
template <class M>
void apply_rows(M& m, const StateLayout& layout, const ResetJacobian& G, bool transpose) {
  constexpr int o = full_offset(Block::kVelocity);
  for (Eigen::Index j = 0; j < m.cols(); ++j) {
    const Eigen::Matrix<double, 6, 1> c = m.col(j).template segment<6>(o);
    if (transpose) {
      m.col(j).template segment<6>(o).noalias() = G.velocity_attitude.transpose() * c;
    } else {
      m.col(j).template segment<6>(o).noalias() = G.velocity_attitude * c;
    }
    for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
      if (!layout.has(kMountingBlocks[i])) continue;
      auto rows = m.col(j).template segment<3>(layout.offset(kMountingBlocks[i]));
      const Vector3d d = rows;
      if (transpose) {
        rows = G.mountings[i].transpose() * d;
      } else {
        rows = G.mountings[i] * d;
      }
    }
  }
}

}  // namespace

Update innovate(const Covariance& P, const StateLayout& layout, const Linearization& lin) {
  Update u;
  u.rows = lin.rows;
  u.H = assemble(layout, lin);
  u.PHt.setZero(layout.size(), 3);
  for (int i = 0; i < lin.count(); ++i) {
    const auto& term = lin.term(i);
    if (!layout.has(term.block)) continue;
    const int o = layout.offset(term.block);
    for (int k = 0; k < info(term.block).size; ++k) {
      for (int r = 0; r < lin.rows; ++r) u.PHt.col(r) += term.jacobian(r, k) * P.col(o + k);
    }
  }
  u.S.setIdentity();
  u.residual.setZero();
  const Matrix3d HPHt = u.H.lazyProduct(u.PHt);
  u.S.topLeftCorner(lin.rows, lin.rows) = 0.5 * (HPHt + HPHt.transpose()).topLeftCorner(lin.rows, lin.rows) +
                                          lin.covariance.topLeftCorner(lin.rows, lin.rows);
  u.R.setIdentity();
  u.R.topLeftCorner(lin.rows, lin.rows) = lin.covariance.topLeftCorner(lin.rows, lin.rows);
  u.observed = std::max(0, layout.offset(lin.observes));
  u.residual.head(lin.rows) = lin.residual.head(lin.rows);
  const Eigen::LLT<Matrix3d> factor(u.S);
  u.S_inverse = factor.solve(Matrix3d::Identity());
  u.nis = u.residual.dot(u.S_inverse * u.residual);
  return u;
}

namespace {

constexpr double kFarBetter = 1e-3;  // ratio of variances, measured over predicted

// A = I − K H without cancellation in the observed block o, for H_o = I: from H K = I − R S⁻¹ follows A_oo = R S⁻¹ +
// Σ_{b≠o} H_b K_b.
Covariance exact_remainder(const Update& u, const Tall& K) {
  Covariance A = -K.lazyProduct(u.H);
  A.diagonal().array() += 1;
  Jacobian others = u.H;
  others.middleCols<3>(u.observed).setZero();
  A.block<3, 3>(u.observed, u.observed) = u.R * u.S_inverse + others.lazyProduct(K);
  return A;
}

}  // namespace

Tall gain(const Update& u) { return u.PHt.lazyProduct(u.S_inverse); }

namespace {

// Whether P − K S Kᵀ keeps all but a few digits: the variance of no combination falls below this part of itself.
bool loses_little(const Update& u) {
  constexpr double kLeast = 1e-4;
  return (u.R.inverse() * u.S).trace() * kLeast < 1;
}

}  // namespace

void update(Covariance& P, const Update& u) {
  if (loses_little(u)) {
    // P − W Wᵀ with W = P Hᵀ L⁻ᵀ, S = L Lᵀ: symmetric by itself.
    Tall W = u.PHt;
    u.S.llt().matrixU().solveInPlace<Eigen::OnTheRight>(W);
    const Eigen::Index n = P.rows();
    const double *a = W.col(0).data(), *b = W.col(1).data(), *c = W.col(2).data();
    for (Eigen::Index j = 0; j < n; ++j) {
      double* column = P.col(j).data();
      for (Eigen::Index i = 0; i < n; ++i) column[i] -= a[i] * a[j] + b[i] * b[j] + c[i] * c[j];
    }
    return;
  }
  // Joseph's form, with rank-three products only.
  const Tall K = gain(u);
  Matrix3d noise = Matrix3d::Zero();
  noise.topLeftCorner(u.rows, u.rows) = u.R.topLeftCorner(u.rows, u.rows);
  P -= K.lazyProduct(u.PHt.transpose());
  // The contribution of the second factor and of the noise: (A P Hᵀ) Kᵀ with A = I − K H, computed from the new rows of
  // P.
  Tall second = -K.lazyProduct(noise);
  for (int k = 0; k < P.cols(); ++k) {
    if (!u.H.col(k).isZero(0)) second += P.col(k) * u.H.col(k).transpose();  // a measurement depends on few blocks
  }
  P -= second.lazyProduct(K.transpose());
  symmetrize(P);
}

namespace {

// P ← G P Gᵀ for a G that turns N rows from `first` on, and no others.
template <int N>
void turn_rows(Covariance& P, Eigen::Index first, const Eigen::Matrix<double, N, N>& G) {
  Eigen::Matrix<double, Eigen::Dynamic, N, 0, kFullSize, N> columns(P.rows(), N);
  columns.noalias() = P.middleCols<N>(first).lazyProduct(G.transpose());
  const Eigen::Matrix<double, N, N> corner = G * columns.template middleRows<N>(first);
  P.middleCols<N>(first) = columns;
  P.middleRows<N>(first) = columns.transpose();
  P.block<N, N>(first, first) = 0.5 * (corner + corner.transpose());
}

}  // namespace

void reset(Covariance& P, const StateLayout& layout, const ResetJacobian& G) {
  turn_rows<6>(P, full_offset(Block::kVelocity), G.velocity_attitude);
  for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
    if (layout.has(kMountingBlocks[i])) turn_rows<3>(P, layout.offset(kMountingBlocks[i]), G.mountings[i]);
  }
}

void reset_adjoint(Eigen::MatrixXd& columns, const StateLayout& layout, const ResetJacobian& G) {
  apply_rows(columns, layout, G, true);
}

void reset_adjoint(ErrorVector& lambda, const StateLayout& layout, const ResetJacobian& G) {
  apply_rows(lambda, layout, G, true);
}

void reset_adjoint(ErrorVector& lambda, Covariance& Lambda, const StateLayout& layout, const ResetJacobian& G) {
  reset_adjoint(lambda, layout, G);
  apply_rows(Lambda, layout, G, true);
  Lambda.transposeInPlace();
  apply_rows(Lambda, layout, G, true);
  symmetrize(Lambda);
}

namespace {

// Whether the measurement is of a block itself, and far better than its prediction.
bool overrules(const Update& u) {
  const bool direct = u.rows == 3 && u.H.middleCols<3>(u.observed).isIdentity(0);
  return direct && (u.R * u.S_inverse).trace() < 3 * kFarBetter;
}

}  // namespace

void update_adjoint(Eigen::MatrixXd& columns, const Update& u) {
  const Tall K = gain(u);
  if (overrules(u)) {
    columns = (exact_remainder(u, K).transpose() * columns).eval();
  } else {
    columns -= u.H.transpose() * (K.transpose() * columns).eval();
  }
}

void update_adjoint(ErrorVector& lambda, const Update& u) {
  const Tall K = gain(u);
  const Vector3d weighted = u.S_inverse * u.residual;
  if (overrules(u)) {
    lambda = (exact_remainder(u, K).transpose() * lambda - u.H.transpose() * weighted).eval();
  } else {
    const Vector3d seen = K.transpose() * lambda;
    lambda -= u.H.transpose() * (seen + weighted);
  }
}

void update_adjoint(ErrorVector& lambda, Covariance& Lambda, const Update& u) {
  update_adjoint(lambda, u);
  const Tall K = gain(u);
  if (overrules(u)) {
    const Covariance A = exact_remainder(u, K);
    Lambda = (A.transpose() * Lambda * A).eval();
    Lambda += u.H.transpose() * u.S_inverse * u.H;
    symmetrize(Lambda);
    return;
  }
  Tall LK(Lambda.rows(), 3);
  LK.noalias() = Lambda.lazyProduct(K);
  // Aᵀ Λ A = Λ − (ΛK) H − Hᵀ (ΛK)ᵀ + Hᵀ (Kᵀ Λ K) H
  const Matrix3d core = K.transpose().lazyProduct(LK) + u.S_inverse;
  Jacobian rows(3, Lambda.cols());
  rows.noalias() = core.lazyProduct(u.H);
  rows -= LK.transpose();
  Lambda -= LK.lazyProduct(u.H);
  Lambda += u.H.transpose().lazyProduct(rows);
  symmetrize(Lambda);
}

}  // namespace piste
