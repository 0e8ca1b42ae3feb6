#include "fit/spectrum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "math/fourier.h"
#include "piste/core/error.h"

namespace piste {

Spectrum welch(std::span<const Vector3d> signal, std::span<const std::uint8_t> usable, double interval,
               std::size_t segment) {
  const std::size_t half = segment / 2;
  const auto length = static_cast<double>(segment);
  std::vector<double> window(segment);
  double power = 0;
  for (std::size_t i = 0; i < segment; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / length);
    power += window[i] * window[i];
  }

  Spectrum out;
  for (std::size_t k = 0; k <= half; ++k) out.frequency.push_back(static_cast<double>(k) / (length * interval));
  out.density.assign(half + 1, Vector3d::Zero());
  FourierTransform fourier;
  std::vector<double> tapered(segment);
  for (std::size_t first = 0; first + segment <= signal.size(); first += half) {
    const auto part = signal.subspan(first, segment);
    if (!usable.empty()) {
      const auto valid = usable.subspan(first, segment);
      if (std::find(valid.begin(), valid.end(), std::uint8_t{0}) != valid.end()) continue;
    }
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& v : part) mean += v / length;
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < segment; ++i) tapered[i] = window[i] * (part[i](axis) - mean(axis));
      const std::vector<std::complex<double>> transform = fourier.forward(tapered);
      for (std::size_t k = 0; k <= half; ++k) {
        const double sides = k == 0 || k == half ? 1 : 2;
        out.density[k](axis) += sides * interval / power * std::norm(transform[k]);
      }
    }
    ++out.segments;
  }
  if (out.segments == 0) {
    throw DataError("spectrum", fmt::format("no {} usable samples follow one another", segment));
  }
  for (Vector3d& d : out.density) d /= out.segments;
  return out;
}

}  // namespace piste
