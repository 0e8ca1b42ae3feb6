#pragma once
/// What the motion says of columns whose units or axes were guessed: a mapping that reads them so.

#include <optional>

#include "piste/inspect/gnss_health.h"
#include "piste/inspect/log_match.h"
#include "piste/inspect/suspicion.h"
#include "piste/io/columns.h"

namespace piste {

/// The mapping of an IMU by what its motion says beside a receiver's: rates for increments and the other way round,
/// other units, reversed forces, other axes. Nothing if the motion agrees with the mapping, or asks for what no mapping
/// can say.
std::optional<ColumnMap> mended(const ColumnMap& map, const LogMatch& match);

/// The mapping of a receiver by what its positions say of its velocities: other units and axes, or latitude and
/// longitude interchanged. Nothing if they agree.
std::optional<ColumnMap> mended(const ColumnMap& map, const VelocityFit& fit);

/// Whether such a mapping puts this fault right.
bool is_mended_by_columns(LogFault fault);

}  // namespace piste
