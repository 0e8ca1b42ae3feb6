#pragma once
/// Compares the velocities of a GNSS log with its positions: their columns, unit and delay.

#include <optional>
#include <string_view>
#include <vector>

#include "piste/inspect/gnss_health.h"

namespace piste {

/// Positions in the world of the first fix.
using Positions = std::vector<Vector3d>;
Positions positions_of(const std::vector<GeodeticFix>& fixes);

/// The fixes with latitude and longitude interchanged, and whether all longitudes may be latitudes.
std::vector<GeodeticFix> interchanged(std::vector<GeodeticFix> fixes);
bool may_be_interchanged(const std::vector<GeodeticFix>& fixes);

/// Speed [m/s] above which a receiver certainly moves.
inline constexpr double kSurelyMoving = 1;

/// Estimates the columns and the unit with which the velocities fit the positions best. They stay as given unless
/// another choice fits clearly better. Uses the sampling, the quantum and the median sigma of `h`. Returns nullopt if
/// hardly any velocity was measured in motion.
std::optional<VelocityFit> fit_velocity(const std::vector<GeodeticFix>& fixes, const Positions& p, const GnssHealth& h);

/// Name of the unit in which 1 m/s is `scale`. @pre `scale` is one that fit_velocity gives
std::string_view speed_unit_name(double scale);

/// The same name as written in a configuration, such as `kn`.
std::string_view speed_unit_text(double scale);

/// The step of the positions between two fixes minus the step by their velocities, with the correction `fit`. Returns
/// nullopt if one of them has no velocity.
std::optional<Vector3d> beyond_velocity(const GeodeticFix& before, const GeodeticFix& now, const Vector3d& step,
                                        const std::optional<VelocityFit>& fit);

}  // namespace piste
