#include "arrow_matrix.h"

#include <algorithm>
#include <stdexcept>

namespace piste {
namespace {

void invert(const Blocks::View& A) {
  if (!invert_definite(A)) throw std::domain_error("normal equations are not positive definite");
}

}  // namespace

void ChainLinks::reset(std::size_t count, Eigen::Index node, Eigen::Index border) {
  F.reset(count, node, node);
  B_transposed.reset(count, border + 1, node);
  noise.reset(count, node, node);
}

void ArrowEquations::reset(std::size_t count, Eigen::Index node, Eigen::Index border) {
  nodes_.reset(count, node, node);
  sides_.reset(count, border + 1, node);
  corner_.reset(1, border + 1, border + 1);
}

void ArrowStretch::reset(std::size_t nodes, std::size_t of_links, Eigen::Index node, Eigen::Index border) {
  equations.reset(nodes, node, border);
  links.reset(of_links, node, border);
}

void ArrowEquations::add(std::size_t node, const ArrowRows& rows) {
  add_product_transposed(1, rows.J[0], rows.J[0], nodes_[node]);
  add_product_transposed(1, rows.K[0], rows.J[0], sides_[node]);
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

ArrowElimination::ArrowElimination(const ArrowStretch& chain) {
  begin(chain.equations.nodes_.size(), chain.equations.nodes_.rows(), chain.equations.sides_.rows() - 1);
  append(chain);
  finish();
}

void ArrowElimination::begin(std::size_t count, Eigen::Index node, Eigen::Index border) {
  const Eigen::Index with_one = border + 1;
  nodes_.resize(count, node, node);
  sides_.resize(count, with_one, node);
  gains_.resize(count - 1, node, node);
  F_.resize(count - 1, node, node);
  noise_.resize(count - 1, node, node);
  told_.reset(1, node, node);
  told_side_.reset(1, with_one, node);
  squares_.reset(1, node, node);
  wide_.reset(1, with_one, node);
  corner_.reset(1, with_one, with_one);
  next_ = 0;
}

void ArrowElimination::append(const ArrowStretch& stretch) {
  const ArrowEquations& equations = stretch.equations;
  const ChainLinks& links = stretch.links;
  auto PF = squares_[0], told = told_[0], B = wide_[0], told_side = told_side_[0], corner = corner_[0];
  corner += equations.corner_[0];
  for (std::size_t k = 0; k < equations.nodes_.size(); ++k, ++next_) {
    auto P = nodes_[next_], side = sides_[next_];
    P = equations.nodes_[k] + told;
    invert(P);
    const auto right = wide_[0];
    B = equations.sides_[k] - told_side;
    side.setZero();
    add_product(1, right, P, side);
    add_product_transposed(-1, side, right, corner);
    if (next_ == gains_.size()) break;
    auto F = F_[next_], noise = noise_[next_], gain = gains_[next_];
    F = links.F[k];
    noise = links.noise[k];
    PF.setZero();
    add_product_transposed(1, P, F, PF);
    told = noise;
    add_product(1, F, PF, told);
    invert(told);
    B = links.B_transposed[k];  // in terms of the border alone
    add_product_transposed(-1, side, F, B);
    told_side.setZero();
    add_product(1, B, told, told_side);
    add_product_transposed(1, told_side, B, corner);
    gain.setZero();  // P Fᵀ told
    add_product(1, PF, told, gain);
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
  const Eigen::VectorXd right = -whole.topRightCorner(g, 1);
  border_ = corner_[0] * right;
  least_ -= border_.dot(right);
}

ArrowVector ArrowElimination::solution() const {
  ArrowVector x{Blocks(nodes_.size(), nodes_.rows(), 1), border_};
  Eigen::VectorXd of_all(border_.size() + 1);
  of_all << border_, 1;
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    x.nodes[i].noalias() = -sides_[i].transpose().lazyProduct(of_all);
    if (i < gains_.size()) x.nodes[i].noalias() += gains_[i].lazyProduct(x.nodes[i + 1]);
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
      // Joseph's form of the covariance with the next node known: what is left stays positive.
      rest.setIdentity();
      add_product(-1, gain, F_[i], rest);
      half.setZero();
      add_product(1, rest, nodes_[i], half);
      of_node.setZero();
      add_product_transposed(1, half, rest, of_node);
      half.setZero();
      add_product(1, gain, noise_[i], half);
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
