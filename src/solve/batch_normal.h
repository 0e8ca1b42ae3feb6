#pragma once
// The normal equations of a batch: the covariance of its errors, and the step of Gauss and Newton.

#include <vector>

#include "batch_solver.h"
#include "math/arrow_matrix.h"

namespace piste {

/// What steps need, with its memory, which is large and serves for all of them.
struct Newton {
  ArrowElimination equations;  ///< of the last step
  BatchStates moved;
};

/// The objective after refine(), and by how much it fell: half the square of what the solution moved, in sigmas of all
/// unknowns together, where it was near.
struct Refined {
  double cost = 0, fall = 0;
  int steps = 0;
  bool settled = false;  ///< what the last step left is small
};

/// Where states go if steps do not settle: they stay what they were, or become the lowest on the way.
enum class WhereNot { kStays, kLowest };

/// Brings `states` to the minimum by steps of Gauss and Newton. Over milliseconds the IMU is so sure that normal
/// equations with its information, as Ceres forms them, have too few digits left for the fixes, and that a step may
/// first raise the objective by its second order, which the next step takes away. Throws DataError if the run does not
/// determine the unknowns.
Refined refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states, Newton& newton,
               WhereNot unsettled, std::size_t threads);

/// Eliminates the normal equations about the states: what they have as covariance is that of the errors of all nodes
/// and the constants. Returns the objective; where that is not finite, not all is eliminated. Throws DataError if the
/// run does not determine them.
double eliminate(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states,
                 std::size_t threads, ArrowElimination& out);

}  // namespace piste
