#pragma once
/// The spectrum of what is left of a fit, as an autoregression, and the filter that makes it white.

#include <cstdint>
#include <vector>

#include "paired_signals.h"

namespace piste {

/// What is left of one triad at one sample; nothing of axes that are not to be used (bit i is axis i).
struct Left {
  Vector3d value;
  std::uint8_t axes = 0;
};

constexpr int kWhiteningOrder = 4;

/// e[k] = Σ_i taps[i] s[k − i stride], taps[0] = 1.
struct Whitening {
  std::vector<double> taps{1};
  /// Of a constant.
  double gain() const;
  LinearFilter filter(std::size_t stride) const;
};

/// Autoregression by least squares over all axes, of equally spaced residuals; outliers beyond 5 `sigma` are left out.
/// No whitening where there are too few.
Whitening autoregression(const std::vector<Left>& left, double sigma);

/// Both signals of a pair through the whitening of each triad, at the stride of the pair.
FilteredPair whitened(const FilteredPair& pair, const Whitening& gyro, const Whitening& accel);

/// Root mean square over usable axes, without what lies far outside; 0 where there are none.
double robust_sigma(const std::vector<Left>& left);

}  // namespace piste
