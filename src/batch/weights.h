#pragma once
// How much each fix of a batch counts: graduated non-convexity, or a loss.

#include <cstddef>
#include <vector>

#include "piste/batch/batch.h"

namespace piste {

/// Weights of fixes by the squares of their whitened residuals.
class BatchWeights {
 public:
  /// `bound`: chi-squared bound of each fix. `graduate`: the solution may still be far from where wrong fixes show;
  /// else only what lies beyond its bound is left out.
  BatchWeights(BatchLoss loss, std::vector<double> bound, std::vector<double> weights, bool graduate);

  const std::vector<double>& values() const { return weights_; }
  /// Sets the weights by the squares of the whitened residuals of a solution, one step further towards the loss that
  /// was asked for. Returns whether the problem must be solved again.
  bool update(const std::vector<double>& squares);

 private:
  BatchLoss loss_;
  std::vector<double> bound_, weights_;
  double mu_ = 0;  // by how much the bound is widened; 1 and less: it is not
  bool begun_;
};

}  // namespace piste
