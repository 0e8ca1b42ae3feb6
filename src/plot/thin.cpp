#include "plot/thin.h"

#include <algorithm>
#include <cmath>
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

bool breaks(std::span<const std::vector<double>> columns, std::size_t row) {
  return std::none_of(columns.begin(), columns.end(), [row](const auto& c) { return std::isfinite(c[row]); });
}

// Rows without a value that follow one with a value.
void append_breaks(std::span<const std::vector<double>> columns, std::vector<std::size_t>& rows) {
  for (std::size_t i = 1; i < columns.front().size(); ++i) {
    if (breaks(columns, i) && !breaks(columns, i - 1)) rows.push_back(i);
  }
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
  append_breaks(columns, rows);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

}  // namespace piste
