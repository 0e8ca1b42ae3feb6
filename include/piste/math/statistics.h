#pragma once
/// Quantiles and bands that the field asks for.

#include <Eigen/Core>
#include <vector>

namespace piste {

/// The middle of the values; of an even number of them, the upper one of the two in the middle. @pre not empty
double median(std::vector<double> values);

/// The median of each axis. @pre not empty
Eigen::Vector3d median_by_axis(const std::vector<Eigen::Vector3d>& values);

/// The value that this part (0 to 1) of the others lies below; where it falls between two values, the lower one.
/// @pre not empty
double quantile(std::vector<double> values, double part);

/// Standard deviation over the median magnitude, of a normal distribution about zero.
inline constexpr double kSigmaOverMedian = 1.4826;

/// x with P(χ²_dof ≤ x) = probability, 0 < probability < 1, dof > 0.
double chi_squared_quantile(double probability, double dof);

/// x with P(z ≤ x) = probability for a standard normal z.
double normal_quantile(double probability);

/// x with P(t ≤ x) = probability for Student's t, 0 < probability < 1, dof > 0.
double student_quantile(double probability, double dof);

/// P(|t| ≥ x) for Student's t, x ≥ 0.
double student_two_sided(double x, double dof);

/// Adjusted p-values in the order given, by Holm's step-down (Holm 1979, Scand. J. Statistics 6): the i-th smallest of
/// m times m + 1 − i, at least the one before it, at most 1. Where those below α are called findings, the probability
/// of even one false finding is at most α, however the tests depend on one another. NaN stays NaN and counts for none.
std::vector<double> holm(std::vector<double> p_values);

struct Band {
  double low = 0, high = 0;
  bool contains(double value) const { return value > low && value < high; }
};

/// Two-sided band that the mean of `count` independent χ²_dof variables, divided by dof, keeps to with `probability`.
Band chi_squared_band(double probability, double dof, double count);

}  // namespace piste
