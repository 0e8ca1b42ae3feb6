#pragma once
/// The velocities of a GNSS log against its positions: their columns, unit and delay.

#include <optional>
#include <string_view>
#include <vector>

#include "piste/inspect/gnss_health.h"

namespace piste {

/// Positions in the world of the first fix.
using Positions = std::vector<Vector3d>;
Positions positions_of(const std::vector<GeodeticFix>& fixes);

/// Speed [m/s] from which a receiver surely moves.
inline constexpr double kSurelyMoving = 1;

/// How the velocities fit the positions best, of all readings of their columns and unit; as they are given unless
/// another reading is clearly better. Uses the sampling, the quantum and the median sigma of `h`. nullopt where hardly
/// any velocity was measured in motion.
std::optional<VelocityFit> fit_velocity(const std::vector<GeodeticFix>& fixes, const Positions& p, const GnssHealth& h);

/// Name of the unit in which what is 1 m/s is `scale`, a scale that fit_velocity gives.
std::string_view speed_unit_name(double scale);

/// A step of the positions between two fixes, less what their velocities say of it, read as `fit` says. nullopt where
/// one has no velocity.
std::optional<Vector3d> beyond_velocity(const GeodeticFix& before, const GeodeticFix& now, const Vector3d& step,
                                        const std::optional<VelocityFit>& fit);

}  // namespace piste
