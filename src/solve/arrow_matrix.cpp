#include "arrow_matrix.h"

#include <Eigen/Cholesky>
#include <utility>

#include "piste/core/error.h"

namespace piste {
namespace {

// By a Cholesky factor of the matrix with unit diagonal, so that units do not matter.
Eigen::MatrixXd inverse_of_definite(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> root(scale.asDiagonal() * A * scale.asDiagonal());
  if (!scale.allFinite() || root.info() != Eigen::Success) {
    throw DataError("batch", "its normal equations are not positive definite");
  }
  const Eigen::MatrixXd unit = root.solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  const Eigen::MatrixXd inverse = scale.asDiagonal() * unit * scale.asDiagonal();
  return 0.5 * (inverse + inverse.transpose());
}

}  // namespace

ArrowMatrix::ArrowMatrix(std::size_t count, Eigen::Index node, Eigen::Index border)
    : nodes(count, Eigen::MatrixXd::Zero(node, node)),
      links(count > 0 ? count - 1 : 0, Eigen::MatrixXd::Zero(node, node)),
      sides(count, Eigen::MatrixXd::Zero(node, border)),
      corner(Eigen::MatrixXd::Zero(border, border)) {}

ArrowElimination::ArrowElimination(ArrowMatrix equations, ArrowVector right, std::vector<ChainLink> chain)
    : A_(std::move(equations)), b_(std::move(right)), chain_(std::move(chain)) {
  ArrowMatrix& A = A_;
  ArrowVector& b = b_;
  double squares = 0;
  for (std::size_t i = 0; i < A.nodes.size(); ++i) {
    const Eigen::MatrixXd P = inverse_of_definite(A.nodes[i]), side = P * A.sides[i];
    const Eigen::VectorXd mean = P * b.nodes[i];
    squares += mean.dot(b.nodes[i]);
    A.corner.noalias() -= A.sides[i].transpose() * side;
    b.border.noalias() -= A.sides[i].transpose() * mean;
    A.nodes[i] = P;
    A.sides[i] = side;
    b.nodes[i] = mean;
    if (i == chain_.size()) break;
    const ChainLink& link = chain_[i];
    const Eigen::MatrixXd FP = link.F * P;
    const Eigen::MatrixXd told = inverse_of_definite(FP * link.F.transpose() + link.noise);  // of z by the past
    const Eigen::MatrixXd gain = FP.transpose() * told, B = link.B - link.F * side;
    const Eigen::VectorXd ahead = link.F * mean + link.c, pull = told * ahead;
    squares -= ahead.dot(pull);
    A.nodes[i + 1] += told;
    const Eigen::MatrixXd told_B = told * B;
    A.sides[i + 1] -= told_B;
    A.corner.noalias() += B.transpose() * told_B;
    b.nodes[i + 1] += pull;
    b.border.noalias() -= B.transpose() * pull;
    A.sides[i].noalias() += gain * B;
    A.links[i] = -gain;
    b.nodes[i].noalias() -= gain * ahead;
  }
  if (A.corner.size() > 0) {
    A.corner = inverse_of_definite(A.corner);
    const Eigen::VectorXd border = A.corner * b.border;
    squares += border.dot(b.border);
    b.border = border;
  }
  depth_ = 0.5 * squares;
}

ArrowVector ArrowElimination::solution() const {
  ArrowVector x = b_;
  for (std::size_t i = x.nodes.size(); i-- > 0;) {
    x.nodes[i].noalias() -= A_.sides[i] * x.border;
    if (i < chain_.size()) x.nodes[i].noalias() -= A_.links[i] * x.nodes[i + 1];
  }
  return x;
}

ArrowMatrix ArrowElimination::covariance() const {
  ArrowMatrix P = A_;
  for (std::size_t i = P.nodes.size(); i-- > 0;) {
    P.sides[i].noalias() = -A_.sides[i] * P.corner;
    if (i < chain_.size()) {
      const Eigen::MatrixXd& gain = A_.links[i];  // its negative
      // Joseph's form of the covariance with the next node known: what is left stays positive.
      const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(gain.rows(), gain.rows()) + gain * chain_[i].F;
      P.nodes[i] = rest * A_.nodes[i] * rest.transpose() + gain * chain_[i].noise * gain.transpose();
      P.sides[i].noalias() -= gain * P.sides[i + 1];
      P.links[i].noalias() = -gain * P.nodes[i + 1] - A_.sides[i] * P.sides[i + 1].transpose();
      P.nodes[i].noalias() -= P.links[i] * gain.transpose();
    }
    P.nodes[i].noalias() -= P.sides[i] * A_.sides[i].transpose();
    P.nodes[i] = (0.5 * (P.nodes[i] + P.nodes[i].transpose())).eval();
  }
  return P;
}

}  // namespace piste
