#pragma once
/// Covariances of the smoothed errors at pairs of epochs of one run.

#include <cstddef>
#include <vector>

#include "piste/filter/run.h"

namespace piste {

/// One number of the navigation error at an epoch: a · (ρ, ν, θ), as in Estimate.
struct ErrorNumber {
  std::size_t row = 0;
  Eigen::Matrix<double, 9, 1> a = Eigen::Matrix<double, 9, 1>::Zero();
};

/// E[x_i x_j] of such numbers x, given all measurements: for each i of `early` (ascending) a row with all j ≥ i, and 0
/// before it. Two smoothed epochs of one run are not independent: for k < j, E[e_k e_jᵀ] = P_k L_{k→j}ᵀ (I − Λ_j P_j)
/// with the closed-loop transition L of the filter (de Jong and MacKinnon 1988, Biometrika 75).
/// @pre `numbers` ascend by row; the run has its history.
Eigen::MatrixXd lagged_covariances(const FilterRun& run, const std::vector<ErrorNumber>& numbers,
                                   const std::vector<std::size_t>& early);

/// E[x²] of each.
std::vector<double> variances(const FilterRun& run, const std::vector<ErrorNumber>& numbers);

}  // namespace piste
