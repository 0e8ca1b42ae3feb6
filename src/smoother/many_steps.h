#pragma once
/// The transition over several steps, as the backward pass of the smoother goes through them.

#include <cstddef>

#include "piste/core/estimate.h"

namespace piste {

/// Rows of (ρ, ν, θ), and what every other error is multiplied by. The adjoint of Φ, taken of the unit vectors of
/// (ρ, ν, θ) through the steps one after the other, is these rows.
struct ManySteps {
  std::size_t count = 0;
  alignas(32) double rows[9][kMostStates];  ///< Φ of (ρ, ν, θ), by what it is applied to
  alignas(32) double decay[kMostStates];    ///< 0 for (ρ, ν, θ)
};

/// out = Φᵀ in, for n rows and some columns.
void apply_transposed(const ManySteps& Phi, const double* in, std::ptrdiff_t n, std::ptrdiff_t columns, double* out);

/// Φᵀ Λ Φ for a symmetric Λ.
Covariance carried(const ManySteps& Phi, const Covariance& Lambda);

}  // namespace piste
