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

void ChainLinks::reset(std::size_t count, Eigen::Index node, Eigen::Index border) {
  F.reset(count, node, node);
  B.reset(count, node, border + 1);
  noise.reset(count, node, node);
}

void ArrowEquations::reset(std::size_t count, Eigen::Index node, Eigen::Index border) {
  nodes_.reset(count, node, node);
  sides_.reset(count, node, border + 1);
  corner_.reset(1, border + 1, border + 1);
}

void ArrowSystem::reset(std::size_t count, Eigen::Index node, Eigen::Index border) {
  equations.reset(count, node, border);
  links.reset(count - 1, node, border);
}

void ArrowEquations::add(std::size_t node, const ArrowRows& rows) {
  add_product_transposed(1, rows.J[0], rows.J[0], nodes_[node]);
  add_product_transposed(1, rows.J[0], rows.K[0], sides_[node]);
  add_product_transposed(1, rows.K[0], rows.K[0], corner_[0]);
}

void ArrowEquations::add(std::size_t node, const Eigen::MatrixXd& J, const Eigen::MatrixXd& K,
                         const Eigen::VectorXd& residual) {
  ArrowRows rows(J.cols(), K.cols());
  for (Eigen::Index first = 0; first < J.rows(); first += 3) {
    const Eigen::Index n = std::min<Eigen::Index>(3, J.rows() - first);
    rows.J[0].setZero();
    rows.K[0].setZero();
    rows.J[0].leftCols(n) = J.middleRows(first, n).transpose();
    rows.K[0].topLeftCorner(K.cols(), n) = K.middleRows(first, n).transpose();
    rows.K[0].bottomLeftCorner(1, n) = residual.segment(first, n).transpose();
    add(node, rows);
  }
}

double ArrowEquations::squares() const { return corner_[0](corner_.rows() - 1, corner_.rows() - 1); }

ArrowElimination::ArrowElimination(ArrowSystem system)
    : nodes_(std::move(system.equations.nodes_)),
      sides_(std::move(system.equations.sides_)),
      gains_(std::move(system.room)),
      chain_(std::move(system.links)) {
  gains_.reset(chain_.size(), nodes_.rows(), nodes_.rows());
  const Eigen::Index n = nodes_.rows(), with_one = sides_.columns(), g = with_one - 1;
  Blocks corner = std::move(system.equations.corner_);
  Blocks squares(2, n, n), tall(2, n, with_one), wide(1, with_one, n);
  auto FP = squares[0], told = squares[1];  // `told`: of the next node, by what stands before it
  auto side = tall[0], told_B = tall[1];
  auto transposed = wide[0];
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    auto P = nodes_[i];
    invert(P);
    side.setZero();
    add_product(1, P, sides_[i], side);
    transposed = sides_[i].transpose();
    add_product(-1, transposed, side, corner[0]);
    sides_[i] = side;
    if (i == chain_.size()) break;
    const auto F = chain_.F[i];
    FP.setZero();
    add_product(1, F, P, FP);
    told = chain_.noise[i];
    add_product_transposed(1, FP, F, told);
    invert(told);
    auto& B = side;  // in terms of the border alone
    B = chain_.B[i];
    add_product(-1, F, sides_[i], B);
    told_B.setZero();
    add_product(1, told, B, told_B);
    nodes_[i + 1] += told;
    sides_[i + 1] -= told_B;
    transposed = B.transpose();
    add_product(1, transposed, told_B, corner[0]);
    auto gain = gains_[i];  // P Fᵀ told
    add_product(1, told, FP, gain);
    gain.transposeInPlace();
    add_product(1, gain, B, sides_[i]);
  }
  least_ = corner[0](g, g);
  corner_ = Blocks(1, g, g);
  border_ = Eigen::VectorXd::Zero(g);
  if (g == 0) return;
  corner_[0] = corner[0].topLeftCorner(g, g);
  invert(corner_[0]);
  const Eigen::VectorXd right = -corner[0].topRightCorner(g, 1);
  border_ = corner_[0] * right;
  least_ -= border_.dot(right);
}

ArrowSystem ArrowElimination::release() && {
  ArrowSystem system;
  system.equations.nodes_ = std::move(nodes_);
  system.equations.sides_ = std::move(sides_);
  system.links = std::move(chain_);
  system.room = std::move(gains_);
  return system;
}

ArrowVector ArrowElimination::solution() const {
  ArrowVector x{Blocks(nodes_.size(), nodes_.rows(), 1), border_};
  Eigen::VectorXd of_all(border_.size() + 1);
  of_all << border_, 1;
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    x.nodes[i].noalias() = -sides_[i].lazyProduct(of_all);
    if (i < gains_.size()) x.nodes[i].noalias() += gains_[i].lazyProduct(x.nodes[i + 1]);
  }
  return x;
}

ArrowMatrix ArrowElimination::covariance() const {
  const Eigen::Index n = nodes_.rows(), g = border_.size();
  ArrowMatrix P{nodes_, Blocks(gains_.size(), n, n), Blocks(nodes_.size(), n, g), corner_[0]};
  Blocks squares(2, n, n);
  auto rest = squares[0], half = squares[1];
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    const auto side = sides_.left(i, g);
    auto of_node = P.nodes[i], of_side = P.sides[i];
    add_product(-1, side, corner_[0], of_side);
    if (i < gains_.size()) {
      const auto gain = gains_[i];
      auto link = P.links[i];
      // Joseph's form of the covariance with the next node known: what is left stays positive.
      rest.setIdentity();
      add_product(-1, gain, chain_.F[i], rest);
      half.setZero();
      add_product(1, rest, nodes_[i], half);
      of_node.setZero();
      add_product_transposed(1, half, rest, of_node);
      half.setZero();
      add_product(1, gain, chain_.noise[i], half);
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
