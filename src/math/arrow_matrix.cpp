#include "arrow_matrix.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace piste {
namespace {

void invert(const Blocks::View& A) {
  if (!invert_definite(A)) throw std::domain_error("normal equations are not positive definite");
}

}  // namespace

void ChainLinks::resize(std::size_t count, Eigen::Index node, Eigen::Index border) {
  F.resize(count, node, node);
  B_transposed.resize(count, border + 1, node);
  noise.resize(count, node, node);
}

void ArrowRows::resize(std::size_t count, Eigen::Index node, Eigen::Index border) {
  J.resize(count, node, 3);
  K.resize(count, border + 1, 3);
}

double ArrowRows::square(std::size_t i, std::size_t node, const ArrowVector& x) const {
  const auto j = J[i], k = K[i];
  const Eigen::Index g = x.border.size();
  Eigen::Vector3d residual = k.row(g).transpose() + j.transpose().lazyProduct(x.nodes[node]);
  residual += k.topRows(g).transpose().lazyProduct(x.border);
  return residual.squaredNorm();
}

void ArrowEquations::reset(std::size_t count, Eigen::Index node, Eigen::Index border) {
  nodes_.reset(count, node, node);
  sides_.reset(count, border + 1, node);
  corner_.reset(1, border + 1, border + 1);
}

void ArrowEquations::add(std::size_t node, const ArrowRows& rows, std::size_t i, double weight) {
  const auto J = rows.J[i], K = rows.K[i];
  add_symmetric_transposed(weight, J, J, nodes_[node]);
  add_product_transposed(weight, K, J, sides_[node]);
  add_symmetric_transposed(weight, K, K, corner_[0]);
}

void ArrowEquations::add(std::size_t node, const Eigen::MatrixXd& J, const Eigen::MatrixXd& K,
                         const Eigen::VectorXd& residual) {
  for (Eigen::Index first = 0; first < J.rows(); first += 3) {
    const Eigen::Index n = std::min<Eigen::Index>(3, J.rows() - first);
    ArrowRows rows(1, J.cols(), K.cols());
    rows.J[0].leftCols(n) = J.middleRows(first, n).transpose();
    rows.K[0].topLeftCorner(K.cols(), n) = K.middleRows(first, n).transpose();
    rows.K[0].bottomLeftCorner(1, n) = residual.segment(first, n).transpose();
    add(node, rows, 0, 1);
  }
}

double ArrowEquations::squares() const { return corner_[0](corner_.rows() - 1, corner_.rows() - 1); }

ArrowElimination::ArrowElimination(const ArrowEquations& equations, ChainLinks links, Eigen::Index full) {
  begin(equations.nodes_.size(), equations.nodes_.rows(), equations.sides_.rows() - 1, full);
  links_ = std::move(links);
  append(equations);
  finish();
}

void ArrowElimination::begin(std::size_t count, Eigen::Index node, Eigen::Index border, Eigen::Index full) {
  const Eigen::Index with_one = border + 1;
  nodes_.resize(count, node, node);
  sides_.resize(count, with_one, node);
  gains_.resize(count - 1, node, node);
  links_.resize(count - 1, node, border);
  informed_.reset(1, node, node);
  informed_side_.reset(1, with_one, node);
  squares_.reset(1, node, node);
  wide_.reset(1, with_one, node);
  corner_.reset(1, with_one, with_one);
  full_ = full;
  next_ = 0;
}

// C ← C + sign A Fᵀ.
void ArrowElimination::add_times_F(double sign, const Blocks::View& A, std::size_t link, Blocks::View C) const {
  const auto F = links_.F[link];
  add_product_transposed(sign, A, F, {C.data(), C.rows(), full_, Blocks::Stride(C.outerStride())});
  for (Eigen::Index j = full_; j < C.cols(); ++j) C.col(j) += sign * F(j, j) * A.col(j);
}

void ArrowElimination::append(const ArrowEquations& next) {
  auto PF = squares_[0], informed = informed_[0], B = wide_[0], informed_side = informed_side_[0], corner = corner_[0];
  corner += next.corner_[0];
  for (std::size_t k = 0; k < next.nodes_.size(); ++k, ++next_) {
    auto P = nodes_[next_], side = sides_[next_];
    P = next.nodes_[k] + informed;
    invert(P);
    B = next.sides_[k] - informed_side;
    set_product(B, P, side);
    add_symmetric_transposed(-1, side, B, corner);
    if (next_ == gains_.size()) break;
    const auto F = links_.F[next_];
    PF.setZero();
    add_times_F(1, P, next_, PF);
    // F PF and the noise: only the lower triangle.
    informed = links_.noise[next_];
    multiply(1, factors(F, PF), true, true,
             {informed.data(), informed.rows(), full_, Blocks::Stride(informed.outerStride())});
    for (Eigen::Index j = full_; j < informed.cols(); ++j) {
      for (Eigen::Index i = j; i < informed.rows(); ++i) informed(i, j) += F(i, i) * PF(i, j);
    }
    invert(informed);
    B = links_.B_transposed[next_];  // in terms of the border alone
    add_times_F(-1, side, next_, B);
    set_product(B, informed, informed_side);
    add_symmetric_transposed(1, informed_side, B, corner);
    auto gain = gains_[next_];  // P Fᵀ informed
    set_product(PF, informed, gain);
    add_product_transposed(1, B, gain, side);
  }
}

void ArrowElimination::finish() {
  const Eigen::Index g = corner_.rows() - 1;
  const Eigen::MatrixXd whole = corner_[0];
  least_ = whole(g, g);
  corner_.reset(1, g, g);
  border_ = Eigen::VectorXd::Zero(g);
  if (g == 0) return;
  corner_[0] = whole.topLeftCorner(g, g);
  invert(corner_[0]);
  const Eigen::VectorXd right = -whole.bottomLeftCorner(1, g).transpose();
  border_ = corner_[0] * right;
  least_ -= border_.dot(right);
}

ArrowVector ArrowElimination::solution() const {
  ArrowVector x{Blocks(nodes_.size(), nodes_.rows(), 1), border_};
  Eigen::VectorXd of_all(border_.size() + 1);
  of_all << border_, 1;
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    x.nodes[i].noalias() = -sides_[i].transpose().lazyProduct(of_all);
    if (i < gains_.size()) add_product(1, gains_[i], x.nodes[i + 1], x.nodes[i]);
  }
  return x;
}

ArrowMatrix ArrowElimination::covariance() const {
  const Eigen::Index n = nodes_.rows(), g = border_.size();
  ArrowMatrix P{nodes_, Blocks(gains_.size(), n, n), Blocks(nodes_.size(), n, g), corner_[0]};
  Blocks squares(2, n, n), tall(1, n, g);
  auto rest = squares[0], half = squares[1];
  auto side = tall[0];
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    side = sides_[i].topRows(g).transpose();
    auto of_node = P.nodes[i], of_side = P.sides[i];
    add_product(-1, side, corner_[0], of_side);
    if (i < gains_.size()) {
      const auto gain = gains_[i];
      auto link = P.links[i];
      // Joseph's form of the covariance given the next node: it stays positive.
      rest.setIdentity();
      add_product(-1, gain, links_.F[i], rest);
      set_product(rest, nodes_[i], half);
      set_product_transposed(half, rest, of_node);
      set_product(gain, links_.noise[i], half);
      add_product_transposed(1, half, gain, of_node);
      add_product(1, gain, P.sides[i + 1], of_side);
      add_product(1, gain, P.nodes[i + 1], link);
      add_product_transposed(-1, side, P.sides[i + 1], link);
      add_product_transposed(1, link, gain, of_node);
    }
    add_product_transposed(-1, of_side, side, of_node);
    of_node = (0.5 * (of_node + of_node.transpose())).eval();
  }
  return P;
}

}  // namespace piste
