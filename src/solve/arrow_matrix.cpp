#include "arrow_matrix.h"

#include <Eigen/Cholesky>

#include "piste/core/error.h"

namespace piste {
namespace {

Eigen::MatrixXd inverse_of_definite(const Eigen::MatrixXd& D) {
  const Eigen::LLT<Eigen::MatrixXd> root(D);
  if (root.info() != Eigen::Success) {
    throw DataError("batch", "its normal equations are not positive definite");
  }
  return root.solve(Eigen::MatrixXd::Identity(D.rows(), D.cols()));
}

}  // namespace

ArrowMatrix::ArrowMatrix(std::size_t count, Eigen::Index node, Eigen::Index border)
    : nodes(count, Eigen::MatrixXd::Zero(node, node)),
      links(count > 0 ? count - 1 : 0, Eigen::MatrixXd::Zero(node, node)),
      sides(count, Eigen::MatrixXd::Zero(node, border)),
      corner(Eigen::MatrixXd::Zero(border, border)) {}

void invert_selected(ArrowMatrix& A) {
  const std::size_t count = A.nodes.size();
  // Elimination from the first node to the last. Afterwards a node's block holds the inverse of what is left of it,
  // and link and side that inverse times what is left of them.
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::MatrixXd D = inverse_of_definite(A.nodes[i]);
    const Eigen::MatrixXd side = D * A.sides[i];
    A.corner.noalias() -= A.sides[i].transpose() * side;
    if (i + 1 < count) {
      const Eigen::MatrixXd link = D * A.links[i];
      A.nodes[i + 1].noalias() -= A.links[i].transpose() * link;
      A.sides[i + 1].noalias() -= A.links[i].transpose() * side;
      A.links[i] = link;
    }
    A.nodes[i] = D;
    A.sides[i] = side;
  }
  if (A.corner.size() > 0) A.corner = inverse_of_definite(A.corner);
  // Back along the chain, with the blocks of the inverse among the next node and the border known.
  for (std::size_t i = count; i-- > 0;) {
    const Eigen::MatrixXd side = A.sides[i];
    A.sides[i].noalias() = -side * A.corner;
    if (i + 1 < count) {
      const Eigen::MatrixXd link = A.links[i];
      A.sides[i].noalias() -= link * A.sides[i + 1];
      A.links[i].noalias() = -link * A.nodes[i + 1] - side * A.sides[i + 1].transpose();
      A.nodes[i].noalias() -= A.links[i] * link.transpose();
    }
    A.nodes[i].noalias() -= A.sides[i] * side.transpose();
    A.nodes[i] = (0.5 * (A.nodes[i] + A.nodes[i].transpose())).eval();
  }
}

}  // namespace piste
