#pragma once
// Parts of the smoothed covariance P − P Λ P, row by row between two fixes: those from which sigmas are computed.
//
// Let Φ lead from a row to the next fix, and Λ be that of the fix. Then P Λ' P = Cᵀ Λ C with C = Φ P and Λ' = Φᵀ Λ Φ.
// Only the columns of errors that change between fixes are computed in each row. The error of a constant has the same
// covariance in all of them.

#include <vector>

#include "filter/considered.h"

namespace piste {

/// A smoothed estimate, and parts of its covariance: position; velocity and attitude; each other block with itself;
/// biases with their drifts. The other entries are zero.
struct SmoothedParts {
  Estimate x;
  Covariance P;
  Matrix3d turn;  ///< reset Jacobian of the attitude's error to `x`
};

/// Computes SmoothedParts for one layout.
class PartsSmoother {
 public:
  explicit PartsSmoother(const StateLayout& layout, Considered considered = {});

  /// Appends to `out` what row() needs of a filter's covariance and mean: kept_size() values.
  void keep(const Covariance& P, const ErrorVector& mean, std::vector<double>& out) const;
  std::size_t kept_size() const { return width_ * n() + n(); }

  /// Computes what is constant between fixes, from λ and Λ at the end of such a stretch, and the filter's P and mean
  /// there.
  void find_constants(const Covariance& P, const ErrorVector& mean, const ErrorVector& lambda,
                      const Covariance& Lambda);

  /// The parts at a row, from the values that keep() stored there, and the filter's estimate. `lanes` holds λ at the
  /// row, and the transposed transition of (ρ, ν, θ) to the place of Λ (StepOperator::Lanes). `decay` is the transition
  /// of the other errors.
  const SmoothedParts& row(const double* kept, const Estimate& x, const double* lanes, const double* decay,
                           const Covariance& Lambda);

 private:
  std::size_t n() const { return static_cast<std::size_t>(layout_.size()); }
  // Index of column `column` in row 0; each further row is kTile further on.
  std::size_t at(std::size_t column) const;
  std::size_t column_of(int state) const { return static_cast<std::size_t>(column_[static_cast<std::size_t>(state)]); }
  double dot(const std::vector<double>& a, std::size_t column_a, const std::vector<double>& b,
             std::size_t column_b) const;

  const StateLayout& layout_;
  Considered considered_;
  std::size_t width_;        // columns, padded to whole tiles
  std::vector<int> state_;   // of each column; −1: none
  std::vector<int> column_;  // of each state; −1: constant
  std::vector<Block> changing_, constants_;
  struct Pair {
    Block bias, drift;
  };
  std::vector<Pair> pairs_;  // in which the drift changes between fixes
  ErrorVector correction_;
  Covariance of_constants_, work_;
  std::vector<double> weights_;         // Λ P of the biases, in the columns of their drifts
  std::vector<double> through_, half_;  // C and U C, in tiles
  SmoothedParts parts_;
};

}  // namespace piste
