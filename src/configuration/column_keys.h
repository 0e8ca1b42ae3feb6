#pragma once
/// Reads the keys of `format: columns`.

#include "piste/io/columns.h"
#include "piste/io/config.h"

namespace piste {

/// Reads the keys columns, delimiter, skip and header of a log with these quantities. Throws ConfigError if a quantity
/// is unknown or lacks its columns, or a unit does not measure it.
ColumnMap read_column_map(const Config& source, std::span<const ColumnQuantity> quantities);

}  // namespace piste
