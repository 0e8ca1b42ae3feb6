#pragma once
/// Means, spreads and quantiles of values, quantiles of distributions, and bands in which a statistic should lie.

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

namespace piste {

/// No value.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr double square(double x) { return x * x; }

/// The mean. @pre not empty
double mean(std::span<const double> values);

/// Root of the mean square; 0 if there are no values.
double root_mean_square(std::span<const double> values);

/// Estimated standard deviation of the population: root of Σ (value − mean)² / (n − 1). NaN if there is only one value.
double standard_deviation(std::span<const double> values);

/// Standard error of the mean: the standard deviation over √n. NaN if there is only one value.
double standard_error(std::span<const double> values);

/// Mean product of each value and the value `lag` before it, both less `centre`: Σ (x_i − c)(x_{i−lag} − c) / n.
/// @pre not empty
double autocovariance(std::span<const double> values, std::size_t lag, double centre);

/// Standard error of the mean of a stationary series with correlated values (Bartlett 1946). Its square is their
/// variance times (1 + 2 Σ ρ) / n, summed up to the first lag with a correlation below 0.05, or 50 lags. @pre not empty
double standard_error_of_series(std::span<const double> values);

/// Two-sided p-value of the hypothesis that the mean is zero, by Student's t with n − 1 degrees of freedom. NaN if
/// there is only one value.
double zero_mean_p_value(std::span<const double> values);

/// The middle value. Of an even number of values, the larger of the two in the middle. @pre not empty
double median(std::vector<double> values);

/// The median of each axis. @pre not empty
Eigen::Vector3d median_by_axis(const std::vector<Eigen::Vector3d>& values);

/// The value below which this part (0 to 1) of the other values lies. Between two values, the lower one. @pre not empty
double quantile(std::vector<double> values, double part);

/// Standard deviation of a normal distribution about zero, divided by the median magnitude of its values.
inline constexpr double kSigmaOverMedian = 1.4826;

/// x with P(χ²_dof ≤ x) = probability, 0 < probability < 1, dof > 0: chi_squared_quantile(0.999, 3) is 16.27, a gate.
double chi_squared_quantile(double probability, double dof);
/// P(χ²_dof > x), the p-value of a sum of squares; 1 if there is no degree of freedom, or x is not above 0.
double chi_squared_above(double x, double dof);

/// x with P(z ≤ x) = probability for a standard normal z: normal_quantile(0.975) is 1.960.
double normal_quantile(double probability);

/// x with P(t ≤ x) = probability for Student's t, 0 < probability < 1, dof > 0.
double student_quantile(double probability, double dof);

/// P(|t| ≥ x) for Student's t, x ≥ 0.
double student_two_sided(double x, double dof);

/// P-values adjusted for many tests, in the order given, by Holm's step-down method (Holm 1979, Scand. J. Statistics
/// 6). The i-th smallest of m p-values is multiplied by m + 1 − i; the result is at least the one before it, and at
/// most 1. If all tests whose adjusted p-value lies below α are called findings, the probability of even one false
/// finding is at most α, however the tests depend on one another. A NaN stays NaN and does not count among the m.
std::vector<double> holm(std::vector<double> p_values);

/// An interval in which a statistic should lie.
struct Band {
  double low = 0, high = 0;
  bool contains(double value) const { return value > low && value < high; }
};

/// Two-sided band in which the mean of `count` independent χ²_dof variables, divided by dof, lies with `probability`.
Band chi_squared_band(double probability, double dof, double count);

}  // namespace piste
