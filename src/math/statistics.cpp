#include "piste/math/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>

namespace piste {

double mean(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double root_mean_square(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double standard_deviation(std::span<const double> values) {
  if (values.size() < 2) return kNaN;
  const double middle = mean(values);
  double sum = 0;
  for (const double v : values) sum += (v - middle) * (v - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double standard_error(std::span<const double> values) {
  return standard_deviation(values) / std::sqrt(static_cast<double>(values.size()));
}

double autocovariance(std::span<const double> values, std::size_t lag, double centre) {
  double sum = 0;
  for (std::size_t i = lag; i < values.size(); ++i) sum += (values[i] - centre) * (values[i - lag] - centre);
  return sum / static_cast<double>(values.size());
}

double standard_error_of_series(std::span<const double> values) {
  constexpr std::size_t kLongestLag = 50;
  constexpr double kNone = 0.05;  // a series of some hundred values does not resolve less correlation
  const double centre = mean(values), variance = autocovariance(values, 0, centre);
  double inflation = 1;
  for (std::size_t lag = 1; lag < std::min(kLongestLag, values.size()) && variance > 0; ++lag) {
    const double rho = autocovariance(values, lag, centre) / variance;
    if (rho < kNone) break;
    inflation += 2 * rho;
  }
  return std::sqrt(variance * inflation / static_cast<double>(values.size()));
}

double zero_mean_p_value(std::span<const double> values) {
  const double error = standard_error(values), distance = std::abs(mean(values));
  if (std::isnan(error)) return error;
  if (error == 0) return distance == 0 ? 1 : 0;
  return student_two_sided(distance / error, static_cast<double>(values.size() - 1));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Eigen::Vector3d median_by_axis(const std::vector<Eigen::Vector3d>& values) {
  Eigen::Vector3d middle;
  std::vector<double> one(values.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(values.begin(), values.end(), one.begin(), [axis](const Eigen::Vector3d& v) { return v(axis); });
    middle(axis) = median(one);
  }
  return middle;
}

double quantile(std::vector<double> values, double part) {
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

double chi_squared_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

double chi_squared_above(double x, double dof) {
  if (!(dof > 0 && x > 0)) return 1;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(dof), x));
}

double normal_quantile(double probability) { return boost::math::quantile(boost::math::normal(), probability); }

double student_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::students_t(dof), probability);
}

double student_two_sided(double x, double dof) {
  return 2 * boost::math::cdf(boost::math::complement(boost::math::students_t(dof), x));
}

std::vector<double> holm(std::vector<double> p_values) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p_values.size(); ++i) {
    if (!std::isnan(p_values[i])) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  double least = 0;
  auto left = static_cast<double>(order.size());
  for (const std::size_t i : order) {
    least = std::min(1.0, std::max(least, left * p_values[i]));
    p_values[i] = least;
    left -= 1;
  }
  return p_values;
}

Band chi_squared_band(double probability, double dof, double count) {
  const double total = dof * count, tail = (1 - probability) / 2;
  return {chi_squared_quantile(tail, total) / total, chi_squared_quantile(1 - tail, total) / total};
}

}  // namespace piste
