#pragma once
// Pieces of a log: what lies in a stretch of time, and how far the gyro turned in it.

#include <algorithm>
#include <span>

#include "piste/core/log.h"

namespace piste {

/// The samples or fixes with begin ≤ time < end.
template <class Samples>
auto range(const Samples& samples, double begin, double end) {
  const auto before = [](double t) { return [t](const auto& s) { return s.time < t; }; };
  const auto a = std::partition_point(samples.begin(), samples.end(), before(begin));
  const auto b = std::partition_point(a, samples.end(), before(end));
  return std::span(samples.data() + (a - samples.begin()), static_cast<std::size_t>(b - a));
}

/// Rotation of the body from `begin` to `end` by the gyro alone, less a constant rate; b(begin) ← b(end).
Quaterniond turned(const Log& log, double begin, double end, const Vector3d& bias);

}  // namespace piste
