#pragma once
/// The six signals of an IMU, as studies name them.

#include <array>
#include <cstddef>
#include <string_view>

#include "piste/core/state_table.h"

namespace piste {

inline constexpr int kSignals = 6;  ///< axes of an IMU: fx fy fz wx wy wz
inline constexpr std::array<std::string_view, kSignals> kSignalNames{"fx", "fy", "fz", "wx", "wy", "wz"};

/// Name, unit, and the factor from SI, of one axis' bias.
struct SignalInfo {
  std::string_view name, unit;
  double factor;
};
constexpr SignalInfo signal_info(int axis) {
  const auto name = kSignalNames[static_cast<std::size_t>(axis)];
  return axis < 3 ? SignalInfo{name, "m/s^2", 1} : SignalInfo{name, "deg/s", kDegreesPerRadian};
}

}  // namespace piste
