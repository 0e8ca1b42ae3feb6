#pragma once
// How much each fix of a batch counts: graduated non-convexity, or a loss.

#include <cstddef>
#include <vector>

#include "piste/solve/batch.h"

namespace piste {

/// Weights of fixes by the squares of their whitened residuals.
class BatchWeights {
 public:
  /// `bound`: chi-squared bound of each fix.
  BatchWeights(BatchLoss loss, std::vector<double> bound, std::vector<double> weights);

  const std::vector<double>& values() const { return weights_; }
  /// Sets the weights by the residuals of a solution, one step further towards truncation. Returns whether any has
  /// changed by more than `enough`.
  bool update(const std::vector<double>& squares);

 private:
  void truncate(const std::vector<double>& squares);

  BatchLoss loss_;
  std::vector<double> bound_, weights_;
  double mu_ = 0;  // how near to truncation: 0, not begun
};

}  // namespace piste
