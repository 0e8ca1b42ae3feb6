#pragma once
// How the attitude's errors of a batch go together over time.

#include "normal.h"
#include "piste/smoother/attitude_lag.h"

namespace piste {

/// Covariances of the attitude's errors at some 2000 pairs of nodes, spread over the run. Their rows are those of the
/// nodes. `P`: the covariance of `solved`.
std::vector<AttitudeLag> attitude_lags(const World& world, const BatchLayout& layout, const Chain& chain,
                                       const BatchStates& states, const ArrowElimination& solved, const ArrowMatrix& P);

}  // namespace piste
