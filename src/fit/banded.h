#pragma once
/// How texts and pages show a mean and the band that it is held against.

#include <fmt/format.h>

#include <string>

#include "piste/math/statistics.h"

namespace piste {

/// With a * where it lies outside.
inline std::string starred(double value, const Band& band) {
  return fmt::format("{:.3f}{}", value, band.contains(value) ? "" : "*");
}

inline std::string band_text(const Band& band) { return fmt::format("{:.3f} to {:.3f}", band.low, band.high); }

inline std::string percent(double probability) { return fmt::format("{:.4g} %", 100 * probability); }

}  // namespace piste
