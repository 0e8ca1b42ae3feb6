#pragma once
// The covariance of a chain of nodes, each tied to the next, with a border of unknowns that all share.

#include <Eigen/Core>
#include <vector>

#include "blocks.h"

namespace piste {

/// The link from node i to node i + 1: z = F x + B (g, 1) + w, where w has the covariance `noise`, and g is the border.
/// The last row of Bᵀ is the constant term.
struct ChainLinks {
  Blocks F, B_transposed, noise;

  ChainLinks() = default;
  /// All zero.
  ChainLinks(std::size_t count, Eigen::Index node, Eigen::Index border) { resize(count, node, border); }
  /// As Blocks do.
  void resize(std::size_t count, Eigen::Index node, Eigen::Index border);
  std::size_t size() const { return F.size(); }
};

/// A vector of all unknowns.
struct ArrowVector {
  Blocks nodes;  ///< a column each
  Eigen::VectorXd border;
};

/// Residuals of measurements, each of one node and the border, J x + K (g, 1): a column of each matrix is a row of J or
/// K. The last element of each row of K is the constant term. At most three columns are used.
struct ArrowRows {
  Blocks J, K;

  ArrowRows() = default;
  ArrowRows(std::size_t count, Eigen::Index node, Eigen::Index border) { resize(count, node, border); }
  /// As Blocks do.
  void resize(std::size_t count, Eigen::Index node, Eigen::Index border);
  /// Square of the residual with all unknowns as in `x`.
  double square(std::size_t i, std::size_t node, const ArrowVector& x) const;
};

/// The sum of squares of residuals of nodes and the border, as normal equations.
class ArrowEquations {
 public:
  ArrowEquations() = default;
  /// None yet.
  ArrowEquations(std::size_t count, Eigen::Index node, Eigen::Index border) { reset(count, node, border); }
  void reset(std::size_t count, Eigen::Index node, Eigen::Index border);
  /// Measurement `i` of `rows`, times its weight.
  void add(std::size_t node, const ArrowRows& rows, std::size_t i, double weight);
  /// Any number of rows.
  void add(std::size_t node, const Eigen::MatrixXd& J, const Eigen::MatrixXd& K, const Eigen::VectorXd& residual);
  /// Sum of the squares with all unknowns zero.
  double squares() const;

 private:
  friend class ArrowElimination;
  // Of a node with itself, and of (g, 1) with itself: only the lower triangle. `sides`: of (g, 1) with a node.
  Blocks nodes_, sides_, corner_;
};

/// Blocks of the covariance of all nodes and the border. The others are not zero, but are not needed.
struct ArrowMatrix {
  Blocks nodes;            ///< of each node with itself
  Blocks links;            ///< of node i with node i + 1
  Blocks sides;            ///< of node i with the border
  Eigen::MatrixXd corner;  ///< of the border with itself
};

/// The nodes eliminated from the first to the last (Takahashi, Fagan and Chen 1973). Solution and covariance follow
/// from it. The information of a link is never formed: over milliseconds it is 1e16 times that of a measurement, whose
/// digits would be lost. The cost is linear in the number of nodes.
class ArrowElimination {
 public:
  ArrowElimination() = default;
  /// Of a whole chain; `full`: as in begin().
  ArrowElimination(const ArrowEquations& equations, ChainLinks links, Eigen::Index full);

  /// Begins a chain of `count` nodes, in the memory of the previous one: memory that the system clears anew costs as
  /// much as filling it. Below their first `full` rows, all F are diagonal.
  void begin(std::size_t count, Eigen::Index node, Eigen::Index border, Eigen::Index full);
  /// The links of the nodes: write each before append() reaches the first of its two nodes. If no size has changed they
  /// are those of the previous chain, else zero.
  ChainLinks& links() { return links_; }
  /// Eliminates the next nodes. The equations are those of priors and measurements alone, without those of the links.
  /// Throws std::domain_error if the first node is not determined.
  void append(const ArrowEquations& next);
  /// After the last node. Throws std::domain_error if the border is not determined.
  void finish();

  ArrowVector solution() const;
  /// Selected blocks of the inverse, computed backwards from the blocks of the border and the next node.
  ArrowMatrix covariance() const;
  /// Covariances of node `late` with each node before it, the last one first: of all their rows with the columns of
  /// `late` that begin at `column`. `P`: covariance().
  template <int kColumns, class Visit>
  void visit_earlier(const ArrowMatrix& P, std::size_t late, Eigen::Index column, Visit&& visit) const {
    const Eigen::Matrix<double, Eigen::Dynamic, kColumns> border =
        P.sides[late].template middleRows<kColumns>(column).transpose();
    Eigen::Matrix<double, Eigen::Dynamic, kColumns> C = P.nodes[late].template middleCols<kColumns>(column);
    for (std::size_t i = late; i-- > 0;) {
      C = (gains_[i] * C - sides_[i].topRows(border.rows()).transpose() * border).eval();
      visit(i, C);
    }
  }
  /// The sum of all squares, of the equations and of the chain, at the solution.
  double least() const { return least_; }

 private:
  void add_times_F(double sign, const Blocks::View& A, std::size_t link, Blocks::View C) const;

  // With the next node z and the border g, x = gain z − sideᵀ (g, 1); `node` is its covariance given all before z.
  Blocks nodes_, sides_, gains_;
  ChainLinks links_;
  Eigen::Index full_ = 0;
  std::size_t next_ = 0;
  Blocks informed_, informed_side_;  // information of the next node from all before it
  Blocks squares_, wide_;            // room
  Blocks corner_;                    // normal equations of (g, 1), then covariance of the border
  Eigen::VectorXd border_;
  double least_ = 0;
};

}  // namespace piste
