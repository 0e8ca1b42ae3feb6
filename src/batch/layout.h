#pragma once
// Which unknowns of a run each node of a batch has, and which are the same in all of them.

#include <vector>

#include "piste/core/estimate.h"

namespace piste {

/// The blocks of a run in two parts: what changes, and stands in every node, and what is constant.
struct BatchLayout {
  explicit BatchLayout(StateLayout whole);

  /// A part: its blocks, and the rows of the run's error vector that its errors have.
  struct Part {
    std::vector<Block> blocks;
    std::vector<int> rows;  ///< of the run's error vector, by row of the part's
    int size() const { return static_cast<int>(rows.size()); }
    /// Row of a block among the errors of the part, −1 if it is not in it.
    int offset(Block block) const;
    /// Number of doubles that hold the values: four for a rotation.
    int stored() const;
    /// Writes the values of the blocks to `values`, or reads them from there.
    void store(const Estimate& x, double* values) const;
    void load(const double* values, Estimate& x) const;
    /// Copies the values of the blocks.
    void copy(const Estimate& from, Estimate& to) const;
    /// x ⊟ from of the part's blocks, which are not those of navigation. No heap.
    void difference(const Estimate& x, const Estimate& from, double* error) const;
    /// Errors of the part from those of all blocks.
    Eigen::VectorXd select(const FullError& error) const;
    /// Writes errors of the part to where the run's error vector has them.
    void put(const double* error, ErrorVector& into) const;
    /// Errors of all blocks from those of the part; zero for the others.
    FullError expand(const double* error) const;
  };

  StateLayout whole;
  Part node, constant;
};

}  // namespace piste
