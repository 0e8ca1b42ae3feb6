#include "rest_match.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

constexpr double kExplains = 30, kOpenMore = 15;  // nats; large, as neighbouring seconds are correlated
constexpr double kOtherOffset = 5;                // s: offsets that differ by more are rivals
constexpr double kAsMuch = 0.5;  // of the best offset's mutual information: an offset with less is no rival

// Numbers of scored offsets: over the whole range, and in the fullest bins. Logs of hours take a second or two.
constexpr std::size_t kScored = 20000, kFullest = 5000;
constexpr double kBin = 0.5;       // s: accuracy with which a log shows the beginning and end of a stationary time
constexpr double kMostBins = 1e6;  // with more, bins are made wider: 16 MB

// Time that two lists of intervals have in common when `other` is `offset` later.
double common(const std::vector<Interval>& one, const std::vector<Interval>& other, double offset) {
  double sum = 0;
  for (auto a = one.begin(), b = other.begin(); a != one.end() && b != other.end();) {
    sum += std::max(0.0, std::min(a->end, b->end + offset) - std::max(a->start, b->start + offset));
    a->end < b->end + offset ? ++a : ++b;
  }
  return sum;
}

// Mutual information of the two logs at an offset, and their variation of information [nats].
struct Candidate {
  double offset, explained, open;
};

Candidate candidate(const Rests& one, const Rests& other, double offset) {
  const double all = common({one.span}, {other.span}, offset), rest_one = common(one.intervals, {other.span}, offset),
               rest_other = common({one.span}, other.intervals, offset),
               both = common(one.intervals, other.intervals, offset);
  const auto surprise = [all](double seconds) { return seconds > 0 ? -seconds * std::log(seconds / all) : 0; };
  const double of_one = surprise(rest_one) + surprise(all - rest_one),
               of_other = surprise(rest_other) + surprise(all - rest_other),
               of_both = surprise(both) + surprise(rest_one - both) + surprise(rest_other - both) +
                         surprise(all - rest_one - rest_other + both);
  return {offset, of_one + of_other - of_both, 2 * of_both - of_one - of_other};
}

// Calls `take` with each offset at which two rests begin or end together.
template <class Take>
void each_offset(const Rests& one, const Rests& other, Take&& take) {
  for (const Interval& a : one.intervals) {
    for (const Interval& b : other.intervals) {
      take(a.start - b.start);
      take(a.end - b.end);
    }
  }
}

// The range of these offsets.
Interval offsets_of(const Rests& one, const Rests& other) {
  return {one.intervals.front().start - other.intervals.back().end,
          one.intervals.back().end - other.intervals.front().start};
}

// The mean offsets of the fullest bins of that width.
std::vector<double> fullest_bins(const Rests& one, const Rests& other, double width, std::size_t most) {
  struct Bin {
    double count = 0, sum = 0;
  };
  const Interval range = offsets_of(one, other);
  std::vector<Bin> bins(static_cast<std::size_t>((range.end - range.start) / width) + 1);
  each_offset(one, other, [&](double offset) {
    Bin& bin = bins[static_cast<std::size_t>((offset - range.start) / width)];
    bin.count += 1;
    bin.sum += offset;
  });
  std::erase_if(bins, [](const Bin& bin) { return bin.count == 0; });
  const auto taken = static_cast<std::ptrdiff_t>(std::min(bins.size(), most));
  std::partial_sort(bins.begin(), bins.begin() + taken, bins.end(),
                    [](const Bin& a, const Bin& b) { return a.count > b.count; });
  std::vector<double> offsets;
  for (auto bin = bins.begin(); bin != bins.begin() + taken; ++bin) offsets.push_back(bin->sum / bin->count);
  return offsets;
}

// The offsets to be scored. All offsets if they are few. Otherwise some over the whole range, where rivals may be, and
// those near which most stationary times begin or end together, where the best one is.
std::vector<double> likely_offsets(const Rests& one, const Rests& other) {
  std::vector<double> offsets;
  if (2 * one.intervals.size() * other.intervals.size() <= kScored) {
    each_offset(one, other, [&](double offset) { offsets.push_back(offset); });
    return offsets;
  }
  const Interval range = offsets_of(one, other);
  const double length = range.end - range.start;
  offsets = fullest_bins(one, other, std::max(kBin, length / static_cast<double>(kScored)), kScored);
  const std::vector<double> fullest = fullest_bins(one, other, std::max(kBin, length / kMostBins), kFullest);
  offsets.insert(offsets.end(), fullest.begin(), fullest.end());
  return offsets;
}

}  // namespace

std::optional<double> match_rests(const Rests& one, const Rests& other) {
  std::vector<Candidate> all;
  for (const double offset : likely_offsets(one, other)) all.push_back(candidate(one, other, offset));
  const auto worse = [](const Candidate& a, const Candidate& b) { return a.explained - a.open < b.explained - b.open; };
  const auto best = std::max_element(all.begin(), all.end(), worse);
  if (best == all.end() || best->explained < kExplains) return std::nullopt;
  const auto rivals = [&best](const Candidate& c) {
    return std::abs(c.offset - best->offset) > kOtherOffset && c.explained > kAsMuch * best->explained &&
           c.open - best->open < kOpenMore;
  };
  if (std::any_of(all.begin(), all.end(), rivals)) return std::nullopt;
  return best->offset;
}

}  // namespace piste
