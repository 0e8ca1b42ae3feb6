#pragma once
/// The transition over several steps, as the backward pass of the smoother accumulates it.

#include <cstddef>

#include "piste/core/estimate.h"

namespace piste {

/// Rows of Φ for (ρ, ν, θ), and the factors of all other errors. The backward pass applies the adjoint of each step to
/// the unit vectors of (ρ, ν, θ); the results are these rows.
struct ManySteps {
  std::size_t count = 0;
  alignas(32) double rows[9][kMostStates];  ///< Φ of (ρ, ν, θ), by the error that it multiplies
  alignas(32) double decay[kMostStates];    ///< 0 for (ρ, ν, θ)
};

/// out = Φᵀ in, for n rows and any number of columns.
void apply_transposed(const ManySteps& Phi, const double* in, std::ptrdiff_t n, std::ptrdiff_t columns, double* out);

/// Φᵀ Λ Φ for a symmetric Λ.
Covariance carried(const ManySteps& Phi, const Covariance& Lambda);

}  // namespace piste
