#include "rest_match.h"

#include <algorithm>
#include <cmath>

namespace piste {
namespace {

constexpr double kExplains = 30, kOpenMore = 15;  // nats, of a second each: neighbouring seconds are much alike
constexpr double kOtherOffset = 5;                // s, of another offset
constexpr double kAsMuch = 0.5;                   // of what the best offset explains: what explains less is no rival

// Time that two lists of intervals have in common when `other` is `offset` later.
double common(const std::vector<Interval>& one, const std::vector<Interval>& other, double offset) {
  double sum = 0;
  for (auto a = one.begin(), b = other.begin(); a != one.end() && b != other.end();) {
    sum += std::max(0.0, std::min(a->end, b->end + offset) - std::max(a->start, b->start + offset));
    a->end < b->end + offset ? ++a : ++b;
  }
  return sum;
}

// What two logs tell of each other at an offset, and what they leave open [nats].
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

}  // namespace

std::optional<double> match_rests(const Rests& one, const Rests& other) {
  std::vector<Candidate> all;  // where two rests begin or end together
  for (const Interval& a : one.intervals) {
    for (const Interval& b : other.intervals) {
      for (const double offset : {a.start - b.start, a.end - b.end}) all.push_back(candidate(one, other, offset));
    }
  }
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
