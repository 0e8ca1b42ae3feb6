#include "core/row_gaps.h"

#include <algorithm>

#include "piste/math/statistics.h"

namespace piste {
namespace {

// The clock is behind by the sum of each interval's excess over a period. Its minimum over all numbers of neighbours is
// the interval's own excess plus the minimum sum on either side.
bool is_behind(std::span<const double> time, std::size_t i, double period, const GapOptions& options) {
  const auto longer = [&](std::size_t k) { return time[k] - time[k - 1] - period; };
  double before = 0, after = 0, sum = 0;
  for (std::size_t k = 1; k <= options.neighbours && i > k; ++k) before = std::min(before, sum += longer(i - k));
  sum = 0;
  for (std::size_t k = 1; k <= options.neighbours && i + k < time.size(); ++k)
    after = std::min(after, sum += longer(i + k));
  return longer(i) + before + after >= options.behind * period;
}

std::vector<std::size_t> gaps_by(std::span<const double> time, double period, const GapOptions& options) {
  std::vector<std::size_t> found;
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] - time[i - 1] > options.long_interval * period && is_behind(time, i, period, options))
      found.push_back(i);
  }
  return found;
}

double first_period(std::span<const double> time, const GapOptions& options) {
  const std::size_t block = std::min(options.block, time.size() - 1);
  std::vector<double> means;
  for (std::size_t i = block; i < time.size(); i += block) {
    means.push_back((time[i] - time[i - block]) / static_cast<double>(block));
  }
  // With so few blocks that a gap is in most of them, the median interval says more.
  if (means.size() < options.fewest_blocks) {
    means.clear();
    for (std::size_t i = 1; i < time.size(); ++i) means.push_back(time[i] - time[i - 1]);
  }
  return quantile(std::move(means), options.blocks_without_gap);
}

}  // namespace

bool RowGaps::before(std::size_t i) const { return std::ranges::binary_search(after, i); }

RowGaps find_gaps(std::span<const double> time, const GapOptions& options) {
  RowGaps gaps;
  if (time.size() < 2) return gaps;
  gaps.period = first_period(time, options);
  gaps.after = gaps_by(time, gaps.period, options);
  double lost = 0;
  for (const std::size_t i : gaps.after) lost += time[i] - time[i - 1];
  if (const std::size_t whole = time.size() - 1 - gaps.after.size(); whole > 0) {
    gaps.period = (time.back() - time.front() - lost) / static_cast<double>(whole);
    gaps.after = gaps_by(time, gaps.period, options);
  }
  return gaps;
}

}  // namespace piste
