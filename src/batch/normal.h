#pragma once
// The normal equations of a batch: the covariance of its errors, and the step of Gauss and Newton.

#include <algorithm>
#include <vector>

#include "math/arrow_matrix.h"
#include "solver.h"

namespace piste {

/// What steps need, with its memory, which is large and serves for all of them.
struct Newton {
  BatchStates at;              ///< where the objective was linearised last, fixes in the terms
  ArrowElimination equations;  ///< about there
  double squares_of_links = 0;
  ArrowVector step;  ///< from there to the states
  double fall = 0;   ///< by which refine() expected that of its last step to lower the objective
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
/// determine the unknowns. @pre fixes are linearised about `states`
Refined refine(BatchTerms& terms, const std::vector<double>& weights, BatchStates& states, Newton& newton,
               WhereNot unsettled, std::size_t threads);

/// The same with other weights, by one step from where the last one was, with the derivatives there. If that is further
/// than where these led before, states stay what they were.
Refined reweigh(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states, Newton& newton,
                std::size_t threads);

/// Squares of the whitened residuals of all fixes, as the last step has left them, to second order.
std::vector<double> squares_of(const BatchTerms& terms, const Newton& newton, std::size_t threads);

/// Eliminates the normal equations about `newton.at`: what they have as covariance is that of the errors of all nodes
/// and the constants. `anew`: of intervals too. Returns the objective; where that is not finite, not all is eliminated.
/// Throws DataError if the run does not determine them.
double eliminate(const BatchTerms& terms, const std::vector<double>& weights, Newton& newton, bool anew,
                 std::size_t threads);

/// What counts for a thousand nodes, for so many: a longer run may move more in all.
inline double by_nodes(double of_thousand, std::size_t nodes) {
  return of_thousand * std::max(1.0, static_cast<double>(nodes) / 1000);
}

}  // namespace piste
