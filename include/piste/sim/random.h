#pragma once
/// Random numbers that are the same on every machine and do not disturb one another.

#include <cstdint>
#include <random>
#include <string_view>

#include "piste/core/options.h"

namespace piste {

/// An independent stream per (seed, name): a sensor that is added, or draws more, changes no other. The standard
/// fixes the bits of mt19937_64 but not those of its distributions, hence our own.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name);
  /// In (0, 1).
  double uniform();
  /// Of N(0, 1), by Box and Muller.
  double normal();
  /// Three of N(0, 1).
  Vector3d normal3();

 private:
  std::mt19937_64 bits_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// One path of an in-run drift, three axes, discretised exactly (Gauss-Markov: b⁺ = e^(−dt/T) b + w,
/// var w = σ² (1 − e^(−2 dt/T)); random walk: var w = density² dt). Gauss-Markov starts in its stationary state,
/// a random walk at 0.
class DriftPath {
 public:
  DriftPath(const DriftProcess& process, RandomStream stream);
  /// A Gauss-Markov path with a sigma per axis.
  DriftPath(const GaussMarkov& process, RandomStream stream);
  const Vector3d& value() const { return value_; }
  /// Moves on by dt > 0 and returns the new value.
  const Vector3d& advance(double dt);

 private:
  DriftProcess::Kind kind_;
  Vector3d scale_;  // sigma, or density
  double correlation_time_;
  RandomStream stream_;
  Vector3d value_ = Vector3d::Zero();
};

}  // namespace piste
