#pragma once
/// Reduces the number of points of a picture without changing what it shows.

#include <cstddef>
#include <span>
#include <vector>

namespace piste {

inline constexpr std::size_t kCurvePoints = 3000;  ///< as many as a picture of a curve shows

/// Ascending indices of about `limit` rows: the first, the last, and those with the smallest and the largest value of
/// each column in each of equally long stretches. All rows if there are no more than `limit`. Values that are not
/// finite are ignored, but of rows without any finite value, which break a curve, the first of each run is kept. @pre
/// the columns are equally long.
std::vector<std::size_t> thin(std::span<const std::vector<double>> columns, std::size_t limit);

}  // namespace piste
