#include "piste/math/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace piste {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double chi_squared_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

double normal_quantile(double probability) { return boost::math::quantile(boost::math::normal(), probability); }

double student_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::students_t(dof), probability);
}

double student_two_sided(double x, double dof) {
  return 2 * boost::math::cdf(boost::math::complement(boost::math::students_t(dof), x));
}

std::vector<double> holm(std::vector<double> p_values) {
  std::vector<double*> ascending;
  for (double& p : p_values) {
    if (!std::isnan(p)) ascending.push_back(&p);
  }
  std::ranges::stable_sort(ascending, {}, [](const double* p) { return *p; });
  double largest = 0;
  auto left = static_cast<double>(ascending.size());
  for (double* p : ascending) *p = largest = std::max(largest, std::min(1.0, left-- * *p));
  return p_values;
}

Band chi_squared_band(double probability, double dof, double count) {
  const double total = dof * count, tail = (1 - probability) / 2;
  return {chi_squared_quantile(tail, total) / total, chi_squared_quantile(1 - tail, total) / total};
}

}  // namespace piste
