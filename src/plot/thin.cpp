#include "plot/thin.h"

#include <algorithm>
#include <numeric>

namespace piste {
namespace {

// Comparisons with NaN are false: if no value is finite, the first row is taken.
void append_extremes(const std::vector<double>& column, std::size_t begin, std::size_t end,
                     std::vector<std::size_t>& rows) {
  std::size_t low = begin, high = begin;
  for (std::size_t i = begin + 1; i < end; ++i) {
    if (column[i] < column[low] || !(column[low] == column[low])) low = i;
    if (column[i] > column[high] || !(column[high] == column[high])) high = i;
  }
  rows.push_back(low);
  rows.push_back(high);
}

}  // namespace

std::vector<std::size_t> thin(std::span<const std::vector<double>> columns, std::size_t limit) {
  const std::size_t size = columns.empty() ? 0 : columns.front().size();
  std::vector<std::size_t> rows;
  if (size <= limit) {
    rows.resize(size);
    std::iota(rows.begin(), rows.end(), std::size_t{0});
    return rows;
  }
  const std::size_t stretches = std::max<std::size_t>(1, limit / (2 * columns.size()));
  rows.push_back(0);
  for (std::size_t k = 0; k < stretches; ++k) {
    const std::size_t begin = k * size / stretches, end = (k + 1) * size / stretches;
    if (begin == end) continue;
    for (const auto& column : columns) append_extremes(column, begin, end, rows);
  }
  rows.push_back(size - 1);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

}  // namespace piste
