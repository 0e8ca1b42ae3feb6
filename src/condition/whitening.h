#pragma once
/// Models the residuals of a fit as an autoregression, and filters signals so that the residuals become white.

#include <cstdint>
#include <vector>

#include "paired_signals.h"

namespace piste {

/// The residual of one triad at one sample, and which axes of it may be used (bit i is axis i).
struct Left {
  Vector3d value;
  std::uint8_t axes = 0;
};

constexpr int kWhiteningOrder = 4;

/// The whitening filter e[k] = Σ_i taps[i] s[k − i stride], with taps[0] = 1.
struct Whitening {
  std::vector<double> taps{1};
  /// Its gain for a constant.
  double gain() const;
  LinearFilter filter(std::size_t stride) const;
};

/// Fits an autoregression to equally spaced residuals, by least squares over all axes. Outliers beyond 5 `sigma` are
/// left out. If there are too few residuals, the result does not change the signals.
Whitening autoregression(const std::vector<Left>& left, double sigma);

/// Filters both signals of a pair by the whitening of each triad, at the stride of the pair.
FilteredPair whitened(const FilteredPair& pair, const Whitening& gyro, const Whitening& accel);

/// Root mean square over usable axes, without outliers. 0 if there are none.
double robust_sigma(const std::vector<Left>& left);

}  // namespace piste
