#include "walker/fix_queue.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/time_search.h"

namespace piste {

void FixQueue::add(QueuedFix&& fix) {
  const auto later = [](const QueuedFix& a, const QueuedFix& b) {
    return a.time != b.time ? a.time < b.time : a.source < b.source;
  };
  fixes_.insert(std::upper_bound(fixes_.begin(), fixes_.end(), fix, later), std::move(fix));
}

std::optional<QueuedFix> FixQueue::take(double time, std::span<const double> delays) {
  const auto belongs = [&](const QueuedFix& fix) { return fix.time - delays[static_cast<std::size_t>(fix.source)]; };
  const double longest = *std::max_element(delays.begin(), delays.end());
  const double until = time + kSameInstant;
  // Whether `a` precedes `b`, which stands earlier in the queue. Less their delays, equal times may differ by rounding.
  const auto before = [&](const QueuedFix& a, const QueuedFix& b) {
    const double later = belongs(a) - belongs(b);
    return std::abs(later) < kSameInstant ? a.source < b.source : later < 0;
  };
  auto next = fixes_.end();
  for (auto it = fixes_.begin(); it != fixes_.end() && it->time - longest <= until; ++it) {
    if (belongs(*it) <= until && (next == fixes_.end() || before(*it, *next))) next = it;
  }
  if (next == fixes_.end()) return std::nullopt;
  std::optional<QueuedFix> fix(std::move(*next));
  fixes_.erase(next);
  return fix;
}

}  // namespace piste
