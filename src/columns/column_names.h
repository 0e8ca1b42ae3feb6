#pragma once
/// Quantities of columns by their names.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "column_table.h"

namespace piste {

/// The quantity of a column by its name: a key of `columns:`, or `time`, `week`, `date`, `roll`, `pitch`, `heading`, or
/// empty. Columns of one triad have the same `group`.
struct ColumnMeaning {
  std::string key;
  char axis = 0;      ///< x, y, z; n, e, d, u; or 0
  std::string group;  ///< the name without the axis
};

ColumnMeaning meaning_of(const SampledColumn& column);

/// The first column of this key, without an axis; nothing if there is none.
std::optional<std::size_t> column_of(const std::vector<ColumnMeaning>& meanings, std::string_view key);

/// Whether a height is named as that above the ellipsoid.
bool is_ellipsoidal(const SampledColumn& column);

}  // namespace piste
