#pragma once
// The normal equations of a batch: the covariance of its errors, and the step of Gauss and Newton.

#include <optional>

#include "batch_solver.h"
#include "math/arrow_matrix.h"

namespace piste {

/// The objective after refine(), and by how much it fell: half the square of what the solution moved, in sigmas of all
/// unknowns together, where it was near.
struct Refined {
  double cost = 0, fall = 0;
  int steps = 0;
  std::optional<ArrowElimination> equations = {};  ///< of the last step if what it left is small, else none

  bool settled() const { return equations.has_value(); }
};

/// Brings `states` to the minimum by steps of Gauss and Newton; where these do not settle, to the lowest place on their
/// way. Over milliseconds the IMU is so sure that normal equations with its information, as Ceres forms them, have too
/// few digits left for the fixes, and that a step may first raise the objective by its second order, which the next
/// step takes away. `room`: an earlier elimination, the memory of which is used. Throws DataError if the run does not
/// determine the unknowns.
Refined refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states,
               std::optional<ArrowElimination> room = {});

/// The normal equations about the states, eliminated: what it has as covariance is that of the errors of all nodes and
/// the constants. Throws DataError if the run does not determine them.
ArrowElimination eliminated(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states);

}  // namespace piste
