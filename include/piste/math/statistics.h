#pragma once
/// Quantiles that the field asks for.

namespace piste {

/// x with P(χ²_dof ≤ x) = probability, 0 < probability < 1, dof > 0.
double chi_squared_quantile(double probability, double dof);

}  // namespace piste
