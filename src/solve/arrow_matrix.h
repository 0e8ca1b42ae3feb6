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

/// The nodes eliminated from the first to the last (Takahashi, Fagan and Chen 1973): from it the solution follows, and
/// the covariance. The information of a link is never formed: over milliseconds it is 1e16 times that of a measurement,
/// and would take all digits of it. The cost is linear in the number of nodes.
class ArrowElimination {
 public:
  /// `A` and `b`: the normal equations of priors and measurements alone, without those of `chain`. Throws DataError if
  /// the first node, or the border, is not determined.
  ArrowElimination(ArrowMatrix A, ArrowVector b, std::vector<ChainLink> chain);

  ArrowVector solution() const;
  /// Selected blocks of the inverse, back from those of the border and the next node.
  ArrowMatrix covariance() const;
  /// Covariances of node `late` with each node before it, the last one first: of all their rows with the columns of
  /// `late` that begin at `column`. `P`: covariance().
  template <int kColumns, class Visit>
  void visit_earlier(const ArrowMatrix& P, std::size_t late, Eigen::Index column, Visit&& visit) const {
    const Eigen::Matrix<double, Eigen::Dynamic, kColumns> border =
        P.sides[late].template middleRows<kColumns>(column).transpose();
    Eigen::Matrix<double, Eigen::Dynamic, kColumns> C = P.nodes[late].template middleCols<kColumns>(column);
    for (std::size_t i = late; i-- > 0;) {
      C = (-A_.links[i] * C - A_.sides[i] * border).eval();
      visit(i, C);
    }
  }
  /// How far the minimum of xᵀ A x / 2 − bᵀ x with all links lies below zero.
  double depth() const { return depth_; }

 private:
  // With the next node z and the border g, x = b − link z − side g; `node` is its covariance by what stands before z.
  ArrowMatrix A_;
  ArrowVector b_;
  std::vector<ChainLink> chain_;
  double depth_ = 0;
};

}  // namespace piste
