#pragma once
/// Names and units of the six signals of an IMU in a study.

#include <array>
#include <cstddef>
#include <string_view>

#include "piste/core/state_table.h"

namespace piste {

inline constexpr int kSignals = 6;  ///< axes of an IMU: fx fy fz wx wy wz
inline constexpr std::array<std::string_view, kSignals> kSignalNames{"fx", "fy", "fz", "wx", "wy", "wz"};

/// Name of an axis, unit of its bias in files, and the factor from SI to that unit.
struct SignalInfo {
  std::string_view name, unit;
  double factor;
};
constexpr SignalInfo signal_info(int axis) {
  const auto name = kSignalNames[static_cast<std::size_t>(axis)];
  return axis < 3 ? SignalInfo{name, "m/s^2", 1} : SignalInfo{name, "deg/s", kDegreesPerRadian};
}

}  // namespace piste
