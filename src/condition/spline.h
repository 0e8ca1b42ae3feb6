#pragma once
/// Cubic spline through samples at unequal steps, for what must be exact between samples.

#include <cstddef>
#include <span>
#include <vector>

#include "piste/math/so3.h"

namespace piste {

/// Not-a-knot cubic spline (natural where there are fewer than four samples) through vectors.
/// Error of its integral over a step: of fifth order in the step; the trapezoid rule has third.
/// Source: de Boor, A Practical Guide to Splines, chapter IV.
class Spline {
 public:
  /// Times strictly increasing, as many as values, at least two. The spline refers to both and must not outlive them.
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
