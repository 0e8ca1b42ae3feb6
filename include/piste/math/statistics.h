#pragma once
/// Quantiles and bands that the field asks for.

#include <vector>

namespace piste {

/// Middle of the values, the upper of two. @pre not empty
double median(std::vector<double> values);

/// x with P(χ²_dof ≤ x) = probability, 0 < probability < 1, dof > 0.
double chi_squared_quantile(double probability, double dof);

/// x with P(z ≤ x) = probability for a standard normal z.
double normal_quantile(double probability);

/// x with P(t ≤ x) = probability for Student's t, 0 < probability < 1, dof > 0.
double student_quantile(double probability, double dof);

/// P(|t| ≥ x) for Student's t, x ≥ 0.
double student_two_sided(double x, double dof);

/// p-values of several tests, each adjusted so that to reject those below α makes even one false rejection with a
/// probability of at most α (Holm 1979, Scandinavian J. Statistics 6). In the order given; NaN stays and does not
/// count.
std::vector<double> holm(std::vector<double> p_values);

struct Band {
  double low = 0, high = 0;
  bool contains(double value) const { return value > low && value < high; }
};

/// Two-sided band that the mean of `count` independent χ²_dof variables, divided by dof, keeps to with `probability`.
Band chi_squared_band(double probability, double dof, double count);

}  // namespace piste
