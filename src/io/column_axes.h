#pragma once
/// The names of the directions along which columns may lie.

#include <array>
#include <string_view>

namespace piste {

/// The name of an axis, and of that against it.
using AxisNames = std::array<std::string_view, 2>;

/// Of velocities and sigmas along the local level, and of the triads of an IMU.
inline constexpr std::array<AxisNames, 3> kLevelAxes{{{"north", "south"}, {"east", "west"}, {"down", "up"}}};
inline constexpr std::array<AxisNames, 3> kSensorAxes{{{"+x", "-x"}, {"+y", "-y"}, {"+z", "-z"}}};

}  // namespace piste
