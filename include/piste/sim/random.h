#pragma once
/// Random numbers that are the same on every machine, in streams that do not depend on one another.

#include <cstdint>
#include <random>
#include <string_view>

#include "piste/core/options.h"

namespace piste {

/// A stream of random numbers for a seed and a name. Streams are independent: if a sensor is added, or draws more
/// numbers, those of the others do not change. The C++ standard fixes the bits of mt19937_64 but not those of its
/// distributions; therefore the distributions here are piste's own.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name);
  /// A number uniform in (0, 1).
  double uniform();
  /// A number of N(0, 1), by the method of Box and Muller.
  double normal();
  /// Three numbers of N(0, 1).
  Vector3d normal3();

 private:
  std::mt19937_64 bits_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// A random path of an in-run drift on three axes, discretised exactly. Gauss-Markov: b⁺ = e^(−dt/T) b + w, var w = σ²
/// (1 − e^(−2 dt/T)), which starts in its stationary state. Random walk: var w = density² dt, which starts at 0.
class DriftPath {
 public:
  DriftPath(const DriftProcess& process, RandomStream stream);
  /// A Gauss-Markov path with a sigma for each axis.
  DriftPath(const GaussMarkov& process, RandomStream stream);
  const Vector3d& value() const { return value_; }
  /// Advances by dt > 0 and returns the new value.
  const Vector3d& advance(double dt);

 private:
  DriftProcess::Kind kind_;
  Vector3d scale_;  // sigma, or density
  double correlation_time_;
  RandomStream stream_;
  Vector3d value_ = Vector3d::Zero();
};

}  // namespace piste
