#pragma once
// The covariance of a chain of nodes, each tied to the next, with a border of unknowns that all share.

#include <Eigen/Core>
#include <vector>

#include "blocks.h"

namespace piste {

/// What ties node i to node i + 1: z = F x + B (g, 1) + w, where w has the covariance `noise`, and g is the border. The
/// last column of B is what does not depend on any of them.
struct ChainLinks {
  Blocks F, B, noise;

  ChainLinks() = default;
  /// All zero.
  ChainLinks(std::size_t count, Eigen::Index node, Eigen::Index border) { reset(count, node, border); }
  void reset(std::size_t count, Eigen::Index node, Eigen::Index border);
  std::size_t size() const { return F.size(); }
};

/// A vector of all unknowns.
struct ArrowVector {
  Blocks nodes;  ///< a column each
  Eigen::VectorXd border;
};

/// Residuals of one node and the border, J x + K (g, 1): a column of each matrix is a row of J or K, and the last
/// element of K's is what does not depend on the unknowns. At most three of them are used.
struct ArrowRows {
  Blocks J, K;

  ArrowRows(Eigen::Index node, Eigen::Index border) : J(1, node, 3), K(1, border + 1, 3) {}
  Eigen::Vector3d residual() const { return K[0].bottomRows<1>().transpose(); }
};

/// The sum of squares of residuals of nodes and the border, as normal equations.
class ArrowEquations {
 public:
  ArrowEquations() = default;
  /// None yet.
  ArrowEquations(std::size_t count, Eigen::Index node, Eigen::Index border) { reset(count, node, border); }
  void reset(std::size_t count, Eigen::Index node, Eigen::Index border);
  void add(std::size_t node, const ArrowRows& rows);
  /// Any number of rows.
  void add(std::size_t node, const Eigen::MatrixXd& J, const Eigen::MatrixXd& K, const Eigen::VectorXd& residual);
  /// Sum of the squares with all unknowns zero.
  double squares() const;

 private:
  friend class ArrowElimination;
  Blocks nodes_, sides_, corner_;  // of a node with itself, and with (g, 1); of (g, 1) with itself
};

/// All that is known of a chain: the measurements of its nodes, its links, and room for what an elimination makes of
/// them. It is large, and memory that the system clears anew costs as much as filling it, so that one system serves for
/// many.
struct ArrowSystem {
  ArrowEquations equations;
  ChainLinks links;
  Blocks room = {};

  /// A chain of `count` nodes of which nothing is known.
  void reset(std::size_t count, Eigen::Index node, Eigen::Index border);
};

/// Blocks of the covariance of all nodes and the border. The others are not zero, but are not needed.
struct ArrowMatrix {
  Blocks nodes;            ///< of each node with itself
  Blocks links;            ///< of node i with node i + 1
  Blocks sides;            ///< of node i with the border
  Eigen::MatrixXd corner;  ///< of the border with itself
};

/// The nodes eliminated from the first to the last (Takahashi, Fagan and Chen 1973): from it the solution follows, and
/// the covariance. The information of a link is never formed: over milliseconds it is 1e16 times that of a measurement,
/// and would take all digits of it. The cost is linear in the number of nodes.
class ArrowElimination {
 public:
  /// The equations are those of priors and measurements alone, without those of the links. Throws std::domain_error if
  /// the first node, or the border, is not determined.
  explicit ArrowElimination(ArrowSystem system);
  /// The memory of a system, for another one.
  ArrowSystem release() &&;

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
      C = (gains_[i] * C - sides_[i].leftCols(border.rows()) * border).eval();
      visit(i, C);
    }
  }
  /// What all squares, of the equations and of the chain, come to at the solution.
  double least() const { return least_; }

 private:
  // With the next node z and the border g, x = gain z − side (g, 1); `node` is its covariance by what stands before z.
  Blocks nodes_, sides_, gains_;
  Blocks corner_;  // covariance of the border
  Eigen::VectorXd border_;
  ChainLinks chain_;
  double least_ = 0;
};

}  // namespace piste
