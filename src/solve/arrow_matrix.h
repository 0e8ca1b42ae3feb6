#pragma once
// The covariance of a chain of nodes, each tied to the next, with a border of unknowns that all share.

#include <Eigen/Core>
#include <vector>

namespace piste {

/// What ties node i to node i + 1: z = F x + B g + c + w, where w has the covariance `noise`, and g is the border.
struct ChainLink {
  Eigen::MatrixXd F, B, noise;
  Eigen::VectorXd c;
};

/// A vector of all unknowns.
struct ArrowVector {
  std::vector<Eigen::VectorXd> nodes;
  Eigen::VectorXd border;
};

/// Blocks of a symmetric matrix over all nodes and the border. In normal equations the others are zero; in their
/// inverse they are not, but are not needed.
struct ArrowMatrix {
  std::vector<Eigen::MatrixXd> nodes;  ///< of each node with itself
  std::vector<Eigen::MatrixXd> links;  ///< of node i with node i + 1
  std::vector<Eigen::MatrixXd> sides;  ///< of node i with the border
  Eigen::MatrixXd corner;              ///< of the border with itself

  ArrowMatrix(std::size_t count, Eigen::Index node, Eigen::Index border);
};

/// Replaces `A` by the same blocks of the covariance. On entry it is the information of priors and measurements alone,
/// without that of `chain`. Forwards the nodes are eliminated, backwards their covariances follow from those of the
/// next node and the border (Takahashi, Fagan and Chen 1973). The information of a link is never formed: over
/// milliseconds it is 1e16 times that of a measurement, and would take all digits of it. The cost is linear in the
/// number of nodes. `b`, on entry the right-hand side of priors and measurements, becomes the solution. Throws
/// DataError if the first node, or the border, is not determined.
void invert_selected(ArrowMatrix& A, ArrowVector& b, const std::vector<ChainLink>& chain);

}  // namespace piste
