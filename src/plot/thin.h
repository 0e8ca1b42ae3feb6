#pragma once
/// Fewer points for the same picture.

#include <cstddef>
#include <span>
#include <vector>

namespace piste {

/// Indices, ascending, of about `limit` rows that show what all of them show: the first, the last, and each column's
/// smallest and largest value in each of equally long stretches. Every row where there are no more than `limit`.
/// A value that is not finite is no extreme. @pre the columns are equally long.
std::vector<std::size_t> thin(std::span<const std::vector<double>> columns, std::size_t limit);

}  // namespace piste
