#pragma once
// From the nodes of a solved batch to the epochs of the IMU between them.

#include <functional>

#include "math/arrow_matrix.h"
#include "piste/smoother/rts.h"
#include "solver.h"

namespace piste {

/// The estimates of all epochs, given those of the nodes: the mean of what the samples and both nodes say (a bridge).
std::shared_ptr<const Reference> epochs_between(const BatchTerms& terms, const FilterOptions& options,
                                                const World& world, const BatchStates& states, std::size_t threads);

/// Calls `visit(row, time, state)` for these rows of the filter, in order. @pre `rows` ascend; `covariance` is
/// the covariance after eliminate() of batch_normal.h
void visit_epochs(const BatchTerms& terms, const FilterOptions& options, const World& world, const BatchStates& states,
                  const ArrowMatrix& covariance, const std::vector<std::size_t>& rows,
                  const std::function<void(std::size_t, double, const SmoothedState&)>& visit);

}  // namespace piste
