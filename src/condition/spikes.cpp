#include "condition/spikes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::size_t kLongest = 2;  // rows

// One axis in the units of a rate.
class SpikeSearch {
 public:
  SpikeSearch(std::span<const double> time, const RowGaps& gaps, std::vector<double> value, double limit,
              const SpikeOptions& options)
      : time_(time), gaps_(gaps), value_(std::move(value)), limit_(limit), options_(options) {}

  std::vector<Spike> run() {
    find_suspects();
    std::vector<Spike> found;
    for (const Spike& s : suspects_) {
      if (const Spike judged = judge(s); judged.departure > 0) found.push_back(judged);
    }
    return found;
  }

 private:
  // The height of row `row` + k above the line between the neighbours of [row, row + count).
  double above_line(std::size_t row, std::size_t count, std::size_t k) const {
    const double part = static_cast<double>(k + 1) / static_cast<double>(count + 1);
    return value_[row + k] - value_[row - 1] - part * (value_[row + count] - value_[row - 1]);
  }

  // The smallest and the largest distance of these rows from it. The smallest is zero if they are on both sides.
  std::pair<double, double> departures(std::size_t row, std::size_t count) const {
    const double first = above_line(row, count, 0), last = above_line(row, count, count - 1);
    const auto [least, most] = std::minmax({std::abs(first), std::abs(last)});
    return {first * last > 0 ? least : 0, most};
  }

  // Whether rows row − 1 to row + count are there, with nothing missing between them. @pre row > 0
  bool whole(std::size_t row, std::size_t count) const {
    if (row + count >= value_.size()) return false;
    const auto gap = std::ranges::lower_bound(gaps_.after, row);
    return gap == gaps_.after.end() || *gap > row + count;
  }

  // Both borders must be abrupt, and so must the departure from the line.
  bool is_suspect(std::size_t row, std::size_t count) const {
    if (!whole(row, count)) return false;
    const double in = value_[row] - value_[row - 1], out = value_[row + count - 1] - value_[row + count];
    return in * out > 0 && std::min(std::abs(in), std::abs(out)) > limit_ && departures(row, count).first > limit_;
  }

  void find_suspects() {
    suspect_.assign(value_.size(), 0);
    for (std::size_t i = 1; i + 1 < value_.size(); ++i) {
      for (std::size_t count = kLongest; count > 0; --count) {  // one row of a spike of two is not a spike of its own
        if (!is_suspect(i, count)) continue;
        suspects_.push_back({.row = i, .count = count});
        for (std::size_t k = 0; k < count; ++k) suspect_[i + k] = 1;
        i += count - 1;
        break;
      }
    }
  }

  // The candidate with its departure and the spread around it. A departure of zero: it is no spike.
  Spike judge(Spike s) const {
    std::size_t first = s.row, last = s.row + s.count;  // rows [first, last) without a gap, within reach
    while (first > 0 && !gaps_.before(first) && time_[s.row] - time_[first - 1] <= options_.around) --first;
    while (last < value_.size() && !gaps_.before(last) && time_[last] - time_[s.row] <= options_.around) ++last;
    if (s.row - first < options_.fewest || last - s.row - s.count < options_.fewest) return {};
    // Candidates are in order: a log that vibrates for hours has many.
    const auto others = std::ranges::lower_bound(suspects_, last, {}, &Spike::row) -
                        std::ranges::lower_bound(suspects_, first, {}, &Spike::row) - 1;
    // At an end of the log there is less time for them.
    const double part = (time_[last - 1] - time_[first]) / (2 * options_.around);
    if (static_cast<double>(others) > part * static_cast<double>(options_.most_others)) return {};
    std::vector<double> around;
    double squares = 0;
    for (std::size_t i = first + 1; i + s.count < last; ++i) {
      const auto rows = std::span(suspect_).subspan(i - 1, s.count + 2);
      if (std::ranges::count(rows, std::uint8_t{1}) > 0) continue;
      around.push_back(departures(i, s.count).second);
      squares += around.back() * around.back();
    }
    if (around.size() < options_.fewest) return {};
    s.departure = departures(s.row, s.count).first;
    s.spread = std::sqrt(squares / static_cast<double>(around.size()));
    const double furthest = *std::ranges::max_element(around);
    const double sigma = kSigmaOverMedian * median(std::move(around));
    if (s.departure <= std::max(options_.sigmas * sigma, options_.furthest * furthest)) return {};
    return s;
  }

  std::span<const double> time_;
  const RowGaps& gaps_;
  std::vector<double> value_;
  double limit_;
  SpikeOptions options_;
  std::vector<Spike> suspects_;
  std::vector<std::uint8_t> suspect_;
};

}  // namespace

std::vector<Spike> find_spikes(std::span<const double> time, const RowGaps& gaps, const std::vector<Vector3d>& values,
                               double period, const Abruptness& abruptness, const SpikeOptions& options) {
  const double limit = std::max(abruptness.per_second * gaps.period, abruptness.least);
  std::vector<Spike> found;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> value;
    value.reserve(values.size());
    for (const Vector3d& v : values) value.push_back(v(axis) / period);
    for (Spike& s : SpikeSearch(time, gaps, std::move(value), limit, options).run()) {
      s.axis = axis;
      found.push_back(s);
    }
  }
  return found;
}

void interpolate_spikes(std::vector<Vector3d>& values, const std::vector<Spike>& spikes) {
  for (const Spike& s : spikes) {
    const double before = values[s.row - 1](s.axis), after = values[s.row + s.count](s.axis);
    for (std::size_t k = 0; k < s.count; ++k) {
      const double part = static_cast<double>(k + 1) / static_cast<double>(s.count + 1);
      values[s.row + k](s.axis) = before + part * (after - before);
    }
  }
}

}  // namespace piste
