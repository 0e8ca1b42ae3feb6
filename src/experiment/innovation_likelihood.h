#pragma once
/// How likely the innovations of a filtered run are.

#include <limits>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// Log-likelihood of one innovation z with the covariance S that the filter gave it, without its constant (Schweppe
/// 1965): ln p(z) of a contaminated normal distribution, 0.99 N(0, S) + 0.01 N(0, 5² S) (Tukey 1960). Up to where a gate
/// of 0.999 rejects, that is −½ (zᵀ S⁻¹ z + ln det S); beyond, a fix counts as spoilt, and outliers do not decide.
double log_likelihood(const Innovation& innovation);

/// The innovations of a run that tell its noise: those of receivers and reference attitudes, without repeated fixes,
/// without the first 15 s after `start`, which tell of the start alone, and without those at rest, which the filter takes to be as
/// coarse as a body sways.
std::vector<Innovation> telling(const Solution& solution, double start, const std::vector<Interval>& rest);

/// Their sum; −∞ of a run without any.
double log_likelihood(const std::vector<Innovation>& innovations);

}  // namespace piste
