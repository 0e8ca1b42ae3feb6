#pragma once
// Minimises the objective of a batch with Ceres.

#include <vector>

#include "terms.h"

namespace piste {

/// The unknowns of a batch: nodes, each with the constants in it.
using BatchStates = std::vector<Estimate>;

/// How one solve went. Costs are half sums of squares, of the intervals and of fixes with their weights.
struct BatchStep {
  double before = 0, after = 0;
  int iterations = 0;
};

/// Minimises over `states`, from where they are. `weights`: of the fixes; those with 0 are left out. Throws DataError
/// if no step can be computed.
BatchStep minimise(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states);

}  // namespace piste
