#include "piste/solve/fix_queue.h"

#include <algorithm>

namespace piste {

void FixQueue::add(QueuedFix&& fix) {
  const auto later = [](const QueuedFix& a, const QueuedFix& b) {
    return a.time != b.time ? a.time < b.time : a.source < b.source;
  };
  fixes_.insert(std::upper_bound(fixes_.begin(), fixes_.end(), fix, later), std::move(fix));
}

const QueuedFix* FixQueue::next(double time) const {
  return taken_ < fixes_.size() && fixes_[taken_].time <= time + kSameInstant ? &fixes_[taken_] : nullptr;
}

void FixQueue::drop_taken() {
  fixes_.erase(fixes_.begin(), fixes_.begin() + static_cast<std::ptrdiff_t>(taken_));
  taken_ = 0;
}

}  // namespace piste
