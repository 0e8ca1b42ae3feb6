#include "arrow_matrix.h"

#include <Eigen/Cholesky>

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

void invert_selected(ArrowMatrix& A, ArrowVector& b, const std::vector<ChainLink>& chain) {
  const std::size_t count = A.nodes.size();
  // Elimination from the first node to the last. Given the next node z and the border g, x = m − link z − side g + e;
  // afterwards a node's block holds the covariance of e, and `b` has m.
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::MatrixXd P = inverse_of_definite(A.nodes[i]), side = P * A.sides[i];
    const Eigen::VectorXd mean = P * b.nodes[i];
    A.corner.noalias() -= A.sides[i].transpose() * side;
    b.border.noalias() -= A.sides[i].transpose() * mean;
    A.nodes[i] = P;
    A.sides[i] = side;
    b.nodes[i] = mean;
    if (i + 1 == count) break;
    const ChainLink& link = chain[i];
    const Eigen::MatrixXd FP = link.F * P;
    const Eigen::MatrixXd told = inverse_of_definite(FP * link.F.transpose() + link.noise);  // of z by the past
    const Eigen::MatrixXd gain = FP.transpose() * told, B = link.B - link.F * side;
    const Eigen::VectorXd ahead = link.F * mean + link.c;
    A.nodes[i + 1] += told;
    A.sides[i + 1].noalias() -= told * B;
    A.corner.noalias() += B.transpose() * told * B;
    b.nodes[i + 1].noalias() += told * ahead;
    b.border.noalias() -= B.transpose() * told * ahead;
    // Joseph's form: what is left stays positive.
    const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - gain * link.F;
    A.nodes[i] = rest * P * rest.transpose() + gain * link.noise * gain.transpose();
    A.sides[i].noalias() += gain * B;
    A.links[i] = -gain;
    b.nodes[i].noalias() -= gain * ahead;
  }
  if (A.corner.size() > 0) {
    A.corner = inverse_of_definite(A.corner);
    b.border = (A.corner * b.border).eval();
  }
  // Back along the chain, with the covariances among the next node and the border known.
  for (std::size_t i = count; i-- > 0;) {
    const Eigen::MatrixXd side = A.sides[i];
    A.sides[i].noalias() = -side * A.corner;
    b.nodes[i].noalias() -= side * b.border;
    if (i + 1 < count) {
      const Eigen::MatrixXd link = A.links[i];
      A.sides[i].noalias() -= link * A.sides[i + 1];
      A.links[i].noalias() = -link * A.nodes[i + 1] - side * A.sides[i + 1].transpose();
      A.nodes[i].noalias() -= A.links[i] * link.transpose();
      b.nodes[i].noalias() -= link * b.nodes[i + 1];
    }
    A.nodes[i].noalias() -= A.sides[i] * side.transpose();
    A.nodes[i] = (0.5 * (A.nodes[i] + A.nodes[i].transpose())).eval();
  }
}

}  // namespace piste
