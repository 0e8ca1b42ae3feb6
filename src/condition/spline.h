#pragma once
/// Cubic spline through samples at unequal steps, with value, derivative and integral.

#include <cstddef>
#include <span>
#include <vector>

#include "piste/math/so3.h"

namespace piste {

/// Not-a-knot cubic spline through vectors; natural if there are fewer than four samples. The error of its integral
/// over a step is of fifth order in the step, that of the trapezoidal rule of third order.
/// Source: de Boor, A Practical Guide to Splines, chapter IV.
class Spline {
 public:
  /// @pre Times increase strictly, there are as many as values, and at least two. The spline refers to both and must
  /// not outlive them.
  Spline(std::span<const double> time, std::span<const Vector3d> value);

  /// Integral from time[i] to time[i + 1].
  Vector3d integral(std::size_t i) const;
  /// Value at t within [time[i], time[i + 1]].
  Vector3d value(std::size_t i, double t) const;
  /// Its derivative.
  Vector3d derivative(std::size_t i, double t) const;

 private:
  std::span<const double> time_;
  std::span<const Vector3d> value_;
  std::vector<Vector3d> second_;  // derivatives at the samples
};

}  // namespace piste
