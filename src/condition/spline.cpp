#include "condition/spline.h"

namespace piste {

Spline::Spline(std::span<const double> time, std::span<const Vector3d> value)
    : time_(time), value_(value), second_(value.size(), Vector3d::Zero()) {
  const std::size_t n = time.size();
  if (n < 3) return;
  const auto step = [&](std::size_t i) { return time[i + 1] - time[i]; };
  const auto slope = [&](std::size_t i) -> Vector3d { return (value[i + 1] - value[i]) / step(i); };
  // Rows 1 … n−2 of  h[i−1] s[i−1] + 2 (h[i−1] + h[i]) s[i] + h[i] s[i+1] = 6 (slope[i] − slope[i−1]).
  // Not-a-knot: the third derivative is continuous at samples 1 and n−2, which eliminates s[0] and s[n−1].
  const bool not_a_knot = n >= 4;
  std::vector<double> upper(n, 0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = step(i - 1), after = step(i);
    double lower = before, diagonal = 2 * (before + after), above = after;
    if (not_a_knot && i == 1) {
      diagonal += before * (before + after) / after;
      above -= before * before / after;
      lower = 0;
    }
    if (not_a_knot && i + 2 == n) {
      diagonal += after * (before + after) / before;
      lower -= after * after / before;
      above = 0;
    }
    if (i == 1) lower = 0;
    const double pivot = diagonal - lower * upper[i - 1];
    upper[i] = above / pivot;
    second_[i] = ((6 * (slope(i) - slope(i - 1))) - lower * second_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i > 1; --i) second_[i - 1] -= upper[i - 1] * second_[i];
  if (not_a_knot) {
    second_[0] = second_[1] + (second_[1] - second_[2]) * (step(0) / step(1));
    second_[n - 1] = second_[n - 2] + (second_[n - 2] - second_[n - 3]) * (step(n - 2) / step(n - 3));
  }
}

Vector3d Spline::integral(std::size_t i) const {
  const double h = time_[i + 1] - time_[i];
  return h / 2 * (value_[i] + value_[i + 1]) - h * h * h / 24 * (second_[i] + second_[i + 1]);
}

Vector3d Spline::value(std::size_t i, double t) const {
  const double h = time_[i + 1] - time_[i];
  const double b = (t - time_[i]) / h, a = 1 - b;
  return a * value_[i] + b * value_[i + 1] +
         h * h / 6 * ((a * a * a - a) * second_[i] + (b * b * b - b) * second_[i + 1]);
}

Vector3d Spline::derivative(std::size_t i, double t) const {
  const double h = time_[i + 1] - time_[i];
  const double b = (t - time_[i]) / h, a = 1 - b;
  return (value_[i + 1] - value_[i]) / h + h / 6 * ((3 * b * b - 1) * second_[i + 1] - (3 * a * a - 1) * second_[i]);
}

}  // namespace piste
