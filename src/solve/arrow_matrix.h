#pragma once
// The normal equations of a batch: a chain of nodes, each of which shares equations with the next, and a border of
// unknowns that all share.

#include <Eigen/Core>
#include <vector>

namespace piste {

/// Blocks of a symmetric matrix. All others are zero in the normal equations; in their inverse they are not, but are
/// not computed either.
struct ArrowMatrix {
  std::vector<Eigen::MatrixXd> nodes;  ///< of each node with itself
  std::vector<Eigen::MatrixXd> links;  ///< of node i with node i + 1
  std::vector<Eigen::MatrixXd> sides;  ///< of node i with the border
  Eigen::MatrixXd corner;              ///< of the border with itself

  ArrowMatrix() = default;
  ArrowMatrix(std::size_t count, Eigen::Index node, Eigen::Index border);
};

/// Replaces `A` by the same blocks of A⁻¹: block elimination along the chain, then the recursion of Takahashi, Fagan
/// and Chen (1973) back along it. The cost is linear in the number of nodes. Throws DataError if A is not
/// positive definite.
void invert_selected(ArrowMatrix& A);

}  // namespace piste
