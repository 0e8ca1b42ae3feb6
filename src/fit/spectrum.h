#pragma once
/// The power spectrum of a signal.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "piste/math/so3.h"

namespace piste {

/// One-sided power spectral density of three axes. White noise of density N [unit/√Hz], as in a sensor file, has the
/// one-sided level 2 N².
struct Spectrum {
  std::vector<double> frequency;  ///< [Hz], from 0 to half of the rate
  std::vector<Vector3d> density;  ///< [unit²/Hz]; its integral is the variance
  int segments = 0;               ///< number of averaged segments; neighbours share half of their samples
};

/// The spectrum by Welch's method: the mean of the periodograms of segments of `segment` samples that overlap by half.
/// The mean of each segment is subtracted, and a Hann window applied. Segments with an unusable sample are left out;
/// `usable` may be empty.
/// Source: Welch 1967, IEEE Trans. Audio and Electroacoustics 15.
/// @pre segment even, at least 4; interval > 0. Throws DataError if there is no usable segment.
Spectrum welch(std::span<const Vector3d> signal, std::span<const std::uint8_t> usable, double interval,
               std::size_t segment);

}  // namespace piste
