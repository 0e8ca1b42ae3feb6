#include "piste/filter/update.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <span>

#include "math/wide.h"

namespace piste {
namespace {

using Tall = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMostStates, 3>;

void symmetrize(Covariance& P) {
  for (int j = 1; j < P.cols(); ++j) {
    for (int i = 0; i < j; ++i) P(i, j) = P(j, i) = 0.5 * (P(i, j) + P(j, i));
  }
}

// M ← Gᵀ M or G M on the rows on which G acts.
template <class M>
void apply_rows(M& m, const StateLayout& layout, const ResetJacobian& G, bool transpose) {
  constexpr int o = full_offset(Block::kVelocity), attitude = full_offset(Block::kAttitude);
  const int lever_arm = layout.offset(Block::kLeverArm);
  for (Eigen::Index j = 0; j < m.cols(); ++j) {
    auto column = m.col(j);
    const Eigen::Matrix<double, 6, 1> c = column.template segment<6>(o);
    const Vector3d position = column.template head<3>();
    if (transpose) {
      column.template segment<6>(o).noalias() = G.velocity_attitude.transpose() * c;
      column.template segment<3>(attitude) += G.position_attitude.transpose() * position;
      if (lever_arm >= 0) column.template segment<3>(lever_arm) += G.position_lever_arm.transpose() * position;
    } else {
      column.template segment<6>(o).noalias() = G.velocity_attitude * c;
      column.template head<3>() += G.position_attitude * c.template tail<3>();
      if (lever_arm >= 0) column.template head<3>() += G.position_lever_arm * column.template segment<3>(lever_arm);
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

namespace {

// Sign of a matrix that is positive or negative definite.
double sign_of(const Matrix3d& S) { return S(0, 0) < 0 ? -1 : 1; }

// A column of P, and the weights of its products with the three rows of H.
struct Seen {
  const double* column;
  double weight[3];
};

// P Hᵀ, from the columns of P that a measurement depends on.
PISTE_WIDE void add_seen(std::span<const Seen> seen, std::ptrdiff_t n, double* __restrict a, double* __restrict b,
                         double* __restrict c) {
  for (const Seen& s : seen) {
    const double* x = s.column;
    const double u = s.weight[0], v = s.weight[1], w = s.weight[2];
    for (std::ptrdiff_t r = 0; r < n; ++r) {
      a[r] += u * x[r];
      b[r] += v * x[r];
      c[r] += w * x[r];
    }
  }
}

// P − sign W Wᵀ for the three columns of W.
PISTE_WIDE void take_away(double* __restrict P, std::ptrdiff_t n, const double* __restrict a,
                          const double* __restrict b, const double* __restrict c, double sign) {
  for (std::ptrdiff_t j = 0; j < n; ++j) {
    double* column = P + j * n;
    const double u = sign * a[j], v = sign * b[j], w = sign * c[j];
    for (std::ptrdiff_t i = 0; i < n; ++i) column[i] -= a[i] * u + b[i] * v + c[i] * w;
  }
}

}  // namespace

Update innovate(const Covariance& P, const StateLayout& layout, const Linearization& lin) {
  Update u;
  u.rows = lin.rows;
  u.H = assemble(layout, lin);
  u.PHt.setZero(layout.size(), 3);
  std::array<Seen, kMostStates> seen;
  std::size_t count = 0;
  for (int i = 0; i < layout.size(); ++i) {
    const auto h = u.H.col(i);
    if (h.isZero(0)) continue;
    seen[count++] = {P.col(i).data(), {h.x(), h.y(), h.z()}};
  }
  add_seen(std::span(seen).first(count), layout.size(), u.PHt.col(0).data(), u.PHt.col(1).data(), u.PHt.col(2).data());
  u.S.setIdentity();
  u.residual.setZero();
  Matrix3d spread = Matrix3d::Zero();  // H P Hᵀ
  for (int i = 0; i < layout.size(); ++i) {
    if (!u.H.col(i).isZero(0)) spread += u.H.col(i) * u.PHt.row(i);
  }
  u.S.topLeftCorner(lin.rows, lin.rows) = 0.5 * (spread + spread.transpose()).topLeftCorner(lin.rows, lin.rows) +
                                          lin.covariance.topLeftCorner(lin.rows, lin.rows);
  u.R.setIdentity();
  u.R.topLeftCorner(lin.rows, lin.rows) = lin.covariance.topLeftCorner(lin.rows, lin.rows);
  u.observed = std::max(0, layout.offset(lin.observes));
  u.residual.head(lin.rows) = lin.residual.head(lin.rows);
  u.S_inverse = inverse_of_definite(u.S);
  u.nis = u.residual.dot(u.S_inverse * u.residual);
  return u;
}

namespace {

constexpr double kFarBetter = 1e-3;  // variance of a measurement over that of its prediction

// A = I − K H without cancellation in the observed block o, for H_o = I: A_oo = R S⁻¹ + Σ_{b≠o} H_b K_b, which follows
// from H K = I − R S⁻¹.
Covariance exact_remainder(const Update& u, const Tall& K) {
  Covariance A = -K.lazyProduct(u.H);
  A.diagonal().array() += 1;
  Jacobian others = u.H;
  others.middleCols<3>(u.observed).setZero();
  A.block<3, 3>(u.observed, u.observed) = u.R * u.S_inverse + others.lazyProduct(K);
  return A;
}

}  // namespace

Matrix3d inverse_of_definite(const Matrix3d& S) {
  const double sign = sign_of(S);
  return sign * (sign * S).llt().solve(Matrix3d::Identity());
}

Tall gain(const Update& u) { return u.PHt.lazyProduct(u.S_inverse); }

namespace {

// Whether P − K S Kᵀ loses few digits: the variance of no combination falls below the fraction kLeast of itself.
bool loses_little(const Update& u) {
  constexpr double kLeast = 1e-4;
  return (u.R.inverse() * u.S).trace() * kLeast < 1;
}

}  // namespace

void update(Covariance& P, const Update& u) {
  if (loses_little(u)) {
    // P − W Wᵀ with W = P Hᵀ L⁻ᵀ, S = L Lᵀ: symmetric by construction. Likewise where S is negative definite.
    const double sign = sign_of(u.S);
    const Matrix3d L = (sign * u.S).llt().matrixL();
    Tall W = u.PHt;
    W.col(0) *= 1 / L(0, 0);
    W.col(1) = (W.col(1) - L(1, 0) * W.col(0)) * (1 / L(1, 1));
    W.col(2) = (W.col(2) - L(2, 0) * W.col(0) - L(2, 1) * W.col(1)) * (1 / L(2, 2));
    take_away(P.data(), P.rows(), W.col(0).data(), W.col(1).data(), W.col(2).data(), sign);
    return;
  }
  // Joseph form, with rank-three products only.
  const Tall K = gain(u);
  Matrix3d noise = Matrix3d::Zero();
  noise.topLeftCorner(u.rows, u.rows) = u.R.topLeftCorner(u.rows, u.rows);
  P -= K.lazyProduct(u.PHt.transpose());
  // The second factor and the noise: (A P Hᵀ) Kᵀ with A = I − K H, from P as already updated.
  Tall second = -K.lazyProduct(noise);
  for (int k = 0; k < P.cols(); ++k) {
    if (!u.H.col(k).isZero(0)) second += P.col(k) * u.H.col(k).transpose();  // a measurement depends on few blocks
  }
  P -= second.lazyProduct(K.transpose());
  symmetrize(P);
}

namespace {

// The columns of velocity and attitude of P Gᵀ, for G = (J Q; 0 J).
PISTE_WIDE void turn_columns(const double* from, std::ptrdiff_t n, const Eigen::Matrix<double, 6, 6>& G,
                             double* __restrict out) {
  const double* g = G.data();
  for (int i = 0; i < 6; ++i) {
    double* to = out + i * n;
    for (std::ptrdiff_t r = 0; r < n; ++r) to[r] = 0;
    for (int k = i < 3 ? 0 : 3; k < 6; ++k) {
      const double w = g[6 * k + i], *x = from + k * n;
      for (std::ptrdiff_t r = 0; r < n; ++r) to[r] += w * x[r];
    }
  }
}

// P ← G P Gᵀ, from the N columns of P Gᵀ on which G acts.
template <int N, class Columns>
void take_turned(Covariance& P, Eigen::Index first, const Eigen::Matrix<double, N, N>& G, const Columns& columns) {
  const Eigen::Matrix<double, N, N> corner = G * columns.template middleRows<N>(first);
  P.middleCols<N>(first) = columns;
  P.middleRows<N>(first) = columns.transpose();
  P.block<N, N>(first, first) = 0.5 * (corner + corner.transpose());
}

}  // namespace

void reset(Covariance& P, const StateLayout& layout, const ResetJacobian& G) {
  constexpr int kVelocity = full_offset(Block::kVelocity), kAttitude = full_offset(Block::kAttitude);
  if (!G.position_attitude.isZero(0) || !G.position_lever_arm.isZero(0)) {
    // P ← S P Sᵀ, where S adds to the rows of the position.
    Tall position = P.leftCols<3>();
    position.noalias() += P.middleCols<3>(kAttitude).lazyProduct(G.position_attitude.transpose());
    if (const int o = layout.offset(Block::kLeverArm); o >= 0) {
      position.noalias() += P.middleCols<3>(o).lazyProduct(G.position_lever_arm.transpose());
    }
    Matrix3d corner = position.topRows<3>() + G.position_attitude * position.middleRows<3>(kAttitude);
    if (const int o = layout.offset(Block::kLeverArm); o >= 0) {
      corner += G.position_lever_arm * position.middleRows<3>(o);
    }
    P.leftCols<3>() = position;
    P.topRows<3>() = position.transpose();
    P.topLeftCorner<3, 3>() = 0.5 * (corner + corner.transpose());
  }
  Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMostStates, 6> columns(P.rows(), 6);
  turn_columns(P.col(kVelocity).data(), P.rows(), G.velocity_attitude, columns.data());
  take_turned<6>(P, kVelocity, G.velocity_attitude, columns);
  for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
    if (!layout.has(kMountingBlocks[i])) continue;
    const int first = layout.offset(kMountingBlocks[i]);
    const Tall turned = P.middleCols<3>(first).lazyProduct(G.mountings[i].transpose());
    take_turned<3>(P, first, G.mountings[i], turned);
  }
}

void reset_adjoint(Eigen::MatrixXd& columns, const StateLayout& layout, const ResetJacobian& G) {
  apply_rows(columns, layout, G, true);
}

void reset_error(ErrorVector& e, const StateLayout& layout, const ResetJacobian& G) { apply_rows(e, layout, G, false); }

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

// Whether the measurement observes a block directly, and is far better than its prediction.
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
  // Aᵀ Λ A + Hᵀ S⁻¹ H = Λ − W H − Hᵀ Wᵀ with W = Λ K − ½ Hᵀ (Kᵀ Λ K + S⁻¹). H has few nonzero columns.
  const Eigen::Index n = Lambda.rows();
  Tall W = Tall::Zero(n, 3);
  std::array<Seen, kMostStates> all;
  for (Eigen::Index k = 0; k < n; ++k)
    all[static_cast<std::size_t>(k)] = {Lambda.col(k).data(), {K(k, 0), K(k, 1), K(k, 2)}};
  add_seen(std::span(all).first(static_cast<std::size_t>(n)), n, W.col(0).data(), W.col(1).data(), W.col(2).data());
  const Matrix3d core = 0.5 * (K.transpose().lazyProduct(W) + u.S_inverse);
  std::array<Eigen::Index, kMostStates> seen;
  std::size_t count = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    if (!u.H.col(k).isZero(0)) seen[count++] = k;
  }
  for (const Eigen::Index k : std::span(seen).first(count)) W.row(k) -= (core * u.H.col(k)).transpose();
  for (const Eigen::Index k : std::span(seen).first(count)) {
    const ErrorVector change = W.lazyProduct(u.H.col(k));
    Lambda.col(k) -= change;
    Lambda.row(k) -= change.transpose();
  }
  // Where both columns are observed, sums above the diagonal were taken in another order than those below it.
  for (const Eigen::Index k : std::span(seen).first(count)) {
    for (const Eigen::Index i : std::span(seen).first(count)) Lambda(i, k) = Lambda(k, i);
  }
}

}  // namespace piste
