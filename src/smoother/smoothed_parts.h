#pragma once
// Of the covariance of a smoothed error, P − P Λ P, those parts of which sigmas are made, row after row between two
// fixes.
//
// With Φ from a row to the next fix and Λ at that fix, P Λ' P = Cᵀ Λ C for C = Φ P. Only the columns of what changes
// between fixes are needed in each row: an error that is constant has the same covariance in all of them.

#include <vector>

#include "piste/core/estimate.h"

namespace piste {

/// A smoothed estimate, and of its covariance the parts: position; velocity and attitude; each other block with itself;
/// biases with their drifts. Elsewhere it is zero.
struct SmoothedParts {
  Estimate x;
  Covariance P;
  Matrix3d turn;  ///< of the attitude's error, by the reset to `x`
};

/// Computes them for one layout.
class PartsSmoother {
 public:
  explicit PartsSmoother(const StateLayout& layout);

  /// Of a filter's covariance what row() needs, appended to `out`: kept_size() values.
  void keep(const Covariance& P, const ErrorVector& mean, std::vector<double>& out) const;
  std::size_t kept_size() const { return width_ * n() + n(); }

  /// Sets what does not change between fixes, from λ and Λ at the end of such a stretch, and the filter's P and mean
  /// there.
  void find_constants(const Covariance& P, const ErrorVector& mean, const ErrorVector& lambda,
                      const Covariance& Lambda);

  /// The parts at a row with what was kept there, and the filter's estimate. `lanes` has the transposed transition of
  /// (ρ, ν, θ) to where Λ is, and λ here (StepOperator::Lanes); `decay` is the transition of the other errors.
  const SmoothedParts& row(const double* kept, const Estimate& x, const double* lanes, const double* decay,
                           const Covariance& Lambda);

 private:
  std::size_t n() const { return static_cast<std::size_t>(layout_.size()); }
  // Where column `column` of row 0 stands; the next rows stand kTile further on.
  std::size_t at(std::size_t column) const;
  std::size_t column_of(int state) const { return static_cast<std::size_t>(column_[static_cast<std::size_t>(state)]); }
  double dot(const std::vector<double>& a, std::size_t column_a, const std::vector<double>& b,
             std::size_t column_b) const;

  const StateLayout& layout_;
  std::size_t width_;        // columns, and some to fill tiles
  std::vector<int> state_;   // of each column; −1: none
  std::vector<int> column_;  // of each state; −1: constant
  std::vector<Block> changing_, constants_;
  struct Pair {
    Block bias, drift;
  };
  std::vector<Pair> pairs_;  // of which the drift changes
  ErrorVector correction_;
  Covariance of_constants_, work_;
  std::vector<double> weights_;         // Λ P of the biases, under their drifts
  std::vector<double> through_, half_;  // C and the upper half of Λ times it, in tiles
  SmoothedParts parts_;
};

}  // namespace piste
