#pragma once
/// Corrects the mapping of columns with guessed units or axes by the motion.

#include <optional>

#include "piste/inspect/gnss_health.h"
#include "piste/inspect/log_match.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/columns.h"

namespace piste {

/// The corrected mapping of an IMU, from its motion and the motion of a receiver: rates for increments and the other
/// way round, other units, reversed forces, other axes. Nothing if the motion agrees with the mapping, or if no mapping
/// can express the correction.
std::optional<ColumnMap> repaired(const ColumnMap& map, const LogMatch& match);

/// The mapping of increments where rates were taken for them.
ColumnMap increments_for_rates(ColumnMap map);

/// The corrected mapping of a receiver, from its positions and velocities: other units and axes, or latitude and
/// longitude interchanged. Nothing if they agree.
std::optional<ColumnMap> repaired(const ColumnMap& map, const VelocityFit& fit);

/// Whether a corrected mapping removes this fault.
bool is_mended_by_columns(LogFault fault);

}  // namespace piste
