#include "search/judged.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "core/time_search.h"
#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/replay/replay.h"
#include "piste/start/attitude_noise.h"
#include "search/whole_log.h"
#include "tune/evidence.h"
#include "tune/thinned.h"

namespace piste {

Ready ready(ReplayConfig config) {
  ReplayOptions options = replay_options(config);
  options.longest = WholeLog::kLongest;
  options.smoother = SmootherKind::kNone;
  const Recording recording = read_recording(config);
  options.filter = with_attitude_sigmas(std::move(options.filter), recording.attitude);
  Log log = thinned(condition(recording, options.conditioning));
  return {std::move(config), std::move(options), std::move(log)};
}

Likelihoods likelihoods(const std::vector<Innovation>& innovations, const std::vector<std::string>& sources) {
  Likelihoods all;
  for (const Innovation& v : innovations) {
    // A delay that is estimated changes when a fix is used, and not its own time.
    const auto microseconds = static_cast<long long>(std::llround(1e6 * (v.time + v.late)));
    all[{sources[static_cast<std::size_t>(v.source)], microseconds}] += log_likelihood({v}, sources);
  }
  return all;
}

double gain(const Likelihoods& one, const Likelihoods& other) {
  double sum = 0;
  for (const auto& [row, ln_p] : one) {
    const auto same = other.find(row);
    if (same != other.end()) sum += ln_p - same->second;
  }
  return sum;
}

namespace {

Likelihoods under_way(const Log& log, const Solution& run) {
  const UnderWay moving(log, run.sources, run.time(0));
  std::vector<Innovation> counted;
  std::ranges::copy_if(run.innovations, std::back_inserter(counted),
                       [&](const Innovation& v) { return moving.contains(v); });
  return likelihoods(counted, run.sources);
}

}  // namespace

std::optional<Likelihoods> weighed(const Inspection& found, const Configured& configured) {
  try {
    Ready r = ready(configured(found));
    const Replay run = replay(std::move(r.log), r.options);
    if (run.filtered.solution.empty()) return std::nullopt;
    return under_way(run.log, run.filtered.solution);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<Judged> judged(const Inspection& found, const Configured& configured) {
  try {
    Ready r = ready(configured(found));
    const Replay run = replay(std::move(r.log), r.options);
    const Solution& filtered = run.filtered.solution;
    if (filtered.empty()) return std::nullopt;
    Judged all{std::move(r.config), diagnosed(run.log, run.options, r.options.heading, run.found, filtered, nullptr)};
    for (const auto& [row, ln_p] : under_way(run.log, filtered)) all.likelihood += ln_p;
    return all;
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace piste
