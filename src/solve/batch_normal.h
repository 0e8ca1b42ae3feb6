#pragma once
// The normal equations of a batch: the covariance of its errors, and the step of Gauss and Newton.

#include "arrow_matrix.h"
#include "batch_solver.h"

namespace piste {

/// Selected blocks of the covariance of the errors of all nodes and the constants. Throws DataError if the run does not
/// determine them.
ArrowMatrix covariance_of(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states);

/// Brings `states` from near the minimum to it, by steps of Gauss and Newton, as long as they make the objective
/// smaller. Normal equations with the information of short intervals in them, as Ceres forms, have too few digits for
/// that. Returns the objective. Throws as covariance_of().
double refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states);

}  // namespace piste
