#include "start/merged_fixes.h"

#include <algorithm>
#include <span>
#include <type_traits>
#include <vector>

#include "core/time_search.h"

namespace piste {
namespace {

bool of_one_kind(const GnssFix& a, const GnssFix& b) {
  return a.quality == b.quality && !a.runs_away && !b.runs_away && a.velocity.has_value() == b.velocity.has_value() &&
         (!a.velocity || a.velocity->has_down() == b.velocity->has_down());
}

// The weighted mean of vectors with independent errors, added one by one.
class Mean {
 public:
  void add(const Vector3d& value, const Vector3d& sigma) {
    const double weight = 1 / sigma.head<2>().squaredNorm();
    weights_ += weight;
    sum_ += weight * value;
    variance_ += (weight * sigma).cwiseAbs2();
  }
  Vector3d value() const { return sum_ / weights_; }
  Vector3d sigma() const { return variance_.cwiseSqrt() / weights_; }

 private:
  double weights_ = 0;
  Vector3d sum_ = Vector3d::Zero(), variance_ = Vector3d::Zero();
};

GnssFix mean_of(std::span<const GnssFix> fixes) {
  GnssFix all = fixes.back();
  if (fixes.size() == 1) return all;
  Mean position, velocity;
  all.slow_change.setZero();
  for (const GnssFix& fix : fixes) {
    position.add(fix.position, fix.sigma_position);
    if (fix.velocity) velocity.add(fix.velocity->value, fix.velocity->sigma);
    all.slow_change += fix.slow_change;
  }
  all.position = position.value();
  all.sigma_position = position.sigma();
  if (all.velocity) all.velocity = FixVelocity{velocity.value(), velocity.sigma()};
  return all;
}

std::vector<GnssFix> merged(const std::vector<GnssFix>& fixes, const std::vector<Interval>& rests, double step) {
  std::vector<GnssFix> out;
  auto rest = rests.begin();
  for (std::size_t first = 0; first < fixes.size();) {
    const double begin = fixes[first].time;
    while (rest != rests.end() && rest->end < begin) ++rest;
    std::size_t end = first + 1;
    if (rest != rests.end() && rest->start <= begin) {
      const double until = std::min(rest->end, begin + step - kSameInstant);
      while (end < fixes.size() && fixes[end].time <= until && of_one_kind(fixes[end - 1], fixes[end])) ++end;
    }
    out.push_back(mean_of(std::span(fixes).subspan(first, end - first)));
    first = end;
  }
  return out;
}

}  // namespace

Log with_merged_fixes(const Log& log, double end, double step) {
  constexpr double kBeyond = 2;  // s: fixes that come late
  return with_each_series(log, [&](const auto& series) {
    using Series = std::decay_t<decltype(series)>;
    Series part(series.begin(), first_at_or_after(series, end + kBeyond));
    if constexpr (std::is_same_v<Series, std::vector<GnssFix>>) part = merged(part, log.rest, step);
    return part;
  });
}

}  // namespace piste
