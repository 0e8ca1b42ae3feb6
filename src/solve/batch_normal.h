#pragma once
// The normal equations of a batch: the covariance of its errors, and the step of Gauss and Newton.

#include "arrow_matrix.h"
#include "batch_solver.h"

namespace piste {

/// Selected blocks of the covariance of the errors of all nodes and the constants. Throws DataError if the run does not
/// determine them.
ArrowMatrix covariance_of(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states);

/// Brings `states` from near the minimum to it, by steps of Gauss and Newton; what is smallest on the way counts. Over
/// milliseconds the IMU is so sure that normal equations with its information, as Ceres forms them, have too few digits
/// left for the fixes, and that a step may first raise the objective by its second order, which the next step takes
/// away. Returns the objective. Throws as covariance_of().
double refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states);

}  // namespace piste
