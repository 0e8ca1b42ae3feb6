#include "piste/fit/phases.h"

#include <algorithm>

#include "piste/condition/aligned_signals.h"
#include "piste/condition/rest_detection.h"

namespace piste {
namespace {

constexpr double kShortestRest = 5, kShortestRun = 1;  // s

double length(const Interval& i) { return i.end - i.start; }
bool shorter(const Interval& a, const Interval& b) { return length(a) < length(b); }

}  // namespace

Phases phases(const std::vector<Interval>& rest, Interval span) {
  std::vector<Interval> rests, runs;
  double moving_since = span.start;
  for (const Interval& whole : rest) {
    const Interval r{std::max(whole.start, span.start), std::min(whole.end, span.end)};
    if (length(r) < kShortestRest) continue;
    rests.push_back(r);
    if (r.start - moving_since >= kShortestRun) runs.push_back({moving_since, r.start});
    moving_since = r.end;
  }
  if (span.end - moving_since >= kShortestRun) runs.push_back({moving_since, span.end});

  Phases out;
  if (runs.empty()) {
    if (!rests.empty()) out.before = *std::max_element(rests.begin(), rests.end(), shorter);
    return out;
  }
  out.run = *std::max_element(runs.begin(), runs.end(), shorter);
  const auto first_after =
      std::partition_point(rests.begin(), rests.end(), [&](const Interval& r) { return r.end <= out.run->start; });
  if (first_after != rests.begin()) out.before = *std::max_element(rests.begin(), first_after, shorter);
  if (first_after != rests.end()) out.after = *std::max_element(first_after, rests.end(), shorter);
  return out;
}

Phases phases(const AlignedImus& imus) {
  const std::vector<Stretch> usable = usable_stretches(imus);
  if (usable.empty()) return {};
  const Interval span{imus.time[usable.front().first] - imus.interval, imus.time[usable.back().last - 1]};
  return phases(detect_rest(imus), span);
}

}  // namespace piste
