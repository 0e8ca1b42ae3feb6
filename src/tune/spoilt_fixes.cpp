#include "tune/spoilt_fixes.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace piste {
namespace {

// The measurements that a run rejects: of each source one in fifty at most, the worst.
std::vector<Innovation> outliers(const Evidence& run) {
  constexpr double kMost = 0.02;
  std::vector<Innovation> all;
  for (std::size_t source = 0; source < run.sources.size(); ++source) {
    std::vector<Innovation> rejected;
    double count = 0;
    for (const Innovation& i : run.innovations) {
      if (i.source != static_cast<int>(source)) continue;
      ++count;
      if (!was_used(i.outcome)) rejected.push_back(i);
    }
    std::stable_sort(rejected.begin(), rejected.end(),
                     [](const Innovation& a, const Innovation& b) { return a.nis > b.nis; });
    rejected.resize(std::min(rejected.size(), static_cast<std::size_t>(kMost * count)));
    all.insert(all.end(), rejected.begin(), rejected.end());
  }
  return all;
}

// Makes the sigmas of what was measured those of a spoilt measurement. `source` is its name in a run.
void spoil(Log& log, std::string_view source, const Innovation& innovation) {
  constexpr double kWider = 5, kSame = 1e-6;  // s
  const double time = innovation.time + innovation.late;
  const auto find = [&](auto& fixes) {
    const auto fix = std::find_if(fixes.begin(), fixes.end(), [&](const auto& f) { return f.time >= time - kSame; });
    return fix != fixes.end() && fix->time <= time + kSame ? &*fix : nullptr;
  };
  for (std::size_t i = 0; i < log.gnss.size(); ++i) {
    if (!source.starts_with(fmt::format("gnss[{}].", i))) continue;
    GnssFix* fix = find(log.gnss[i]);
    if (fix == nullptr) continue;
    if (source.ends_with("position")) {
      fix->sigma_position *= kWider;
      fix->slow_level /= kWider;
    }
    if (source.ends_with("velocity") && fix->velocity) fix->velocity->sigma *= kWider;
  }
  for (std::size_t i = 0; i < log.attitude.size(); ++i) {
    if (source != fmt::format("attitude[{}]", i)) continue;
    if (AttitudeFix* fix = find(log.attitude[i])) fix->covariance *= kWider * kWider;
  }
}

}  // namespace

Log with_spoilt_fixes(Log log, const Evidence& run) {
  for (const Innovation& i : outliers(run)) spoil(log, run.sources[static_cast<std::size_t>(i.source)], i);
  return log;
}

bool same_sigmas(const Log& a, const Log& b) {
  const auto same_fix = [](const GnssFix& x, const GnssFix& y) {
    return x.sigma_position == y.sigma_position && (!x.velocity || x.velocity->sigma == y.velocity->sigma);
  };
  const auto same_attitude = [](const AttitudeFix& x, const AttitudeFix& y) { return x.covariance == y.covariance; };
  const auto same = [](const auto& x, const auto& y, const auto& equal) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(), [&](const auto& p, const auto& q) {
      return std::equal(p.begin(), p.end(), q.begin(), q.end(), equal);
    });
  };
  return same(a.gnss, b.gnss, same_fix) && same(a.attitude, b.attitude, same_attitude);
}

}  // namespace piste
