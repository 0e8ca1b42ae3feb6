#include "plot/thin.h"

#include <algorithm>
#include <array>
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

// The statistics of one column that a sample must share with all rows: numbers of each row.
constexpr std::size_t kTraits = 5;
using Traits = std::array<double, kTraits>;
Traits traits_of(double value) {
  if (!std::isfinite(value)) return {};
  const double size = std::abs(value);
  return {1, value, value * value, size > 1 ? 1. : 0., size > 2 ? 1. : 0.};
}

// Of all columns, each less its mean and over its standard deviation: a perfect sample has the sum 0.
class Balance {
 public:
  explicit Balance(std::span<const std::vector<double>> columns)
      : columns_(columns), mean_(columns.size()), weight_(columns.size()), sum_(columns.size()) {
    const auto count = static_cast<double>(columns.front().size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      Traits square{};
      for (const double value : columns[c]) {
        const Traits t = traits_of(value);
        for (std::size_t k = 0; k < kTraits; ++k) {
          mean_[c][k] += t[k] / count;
          square[k] += t[k] * t[k] / count;
        }
      }
      for (std::size_t k = 0; k < kTraits; ++k) {
        const double variance = square[k] - mean_[c][k] * mean_[c][k];
        weight_[c][k] = variance > 0 ? 1 / std::sqrt(variance) : 0;
      }
    }
  }
  /// The square of the sum if the row is taken.
  double with(std::size_t row) const {
    double square = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const Traits t = traits_of(columns_[c][row]);
      for (std::size_t k = 0; k < kTraits; ++k) {
        const double sum = sum_[c][k] + (t[k] - mean_[c][k]) * weight_[c][k];
        square += sum * sum;
      }
    }
    return square;
  }
  void take(std::size_t row) {
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const Traits t = traits_of(columns_[c][row]);
      for (std::size_t k = 0; k < kTraits; ++k) sum_[c][k] += (t[k] - mean_[c][k]) * weight_[c][k];
    }
  }

 private:
  std::span<const std::vector<double>> columns_;
  std::vector<Traits> mean_, weight_, sum_;
};

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

std::vector<std::size_t> sample(std::span<const std::vector<double>> columns, std::size_t limit) {
  const std::size_t size = columns.empty() ? 0 : columns.front().size();
  if (size <= limit) return thin(columns, limit);
  std::vector<std::size_t> rows;
  for (const auto& column : columns) append_extremes(column, 0, size, rows);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  Balance balance(columns);
  for (const std::size_t row : rows) balance.take(row);
  const std::vector<std::size_t> extremes = rows;
  for (std::size_t k = 0; k < limit; ++k) {
    std::size_t best = size;
    double least = 0;
    for (std::size_t row = k * size / limit; row < (k + 1) * size / limit; ++row) {
      if (std::binary_search(extremes.begin(), extremes.end(), row)) continue;
      const double sum = balance.with(row);
      if (best < size && sum >= least) continue;
      best = row;
      least = sum;
    }
    if (best == size) continue;
    balance.take(best);
    rows.push_back(best);
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

}  // namespace piste
