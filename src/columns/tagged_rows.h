#pragma once
/// Finds the tables of a log whose rows begin with the name of a message, and have columns of their own each.

#include <string>
#include <string_view>
#include <vector>

#include "column_table.h"

namespace piste {

/// The rows of one message. Their columns are known by number alone, the first being the name.
struct TaggedRows {
  std::string tag;
  ColumnTable table;
};

/// Those whose columns the log itself names: Android's GnssLogger in comments (`# Fix,Provider,…`), FlySight by `$COL`
/// and `$UNIT`, autopilots by `FMT`. Samples a text, which must outlive the tables.
std::vector<TaggedRows> tagged_rows(std::string_view text);

/// The pairs of the log's own time and GPS seconds of week of rows that state both, as FlySight's `$TIME`.
std::vector<std::pair<double, double>> tagged_clock(std::string_view text);

}  // namespace piste
