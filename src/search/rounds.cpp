#include "piste/search/rounds.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/diagnosis/diagnose.h"
#include "piste/replay/replay.h"
#include "piste/start/attitude_noise.h"
#include "search/whole_log.h"
#include "tune/evidence.h"
#include "tune/thinned.h"

namespace piste {
namespace {

constexpr std::size_t kReplays = 5, kMostTried = 3;  // of the causes of a round

// A replay of a configuration: the verdict, and how likely its innovations are.
struct Judged {
  ReplayConfig config;
  Diagnosis diagnosis;
  double likelihood = 0;
};

double likelihood_of(const Log& log, const Solution& run) {
  const UnderWay under_way(log, run.sources, run.time(0));
  std::vector<Innovation> counted;
  for (const Innovation& v : run.innovations) {
    if (under_way.contains(v)) counted.push_back(v);
  }
  return log_likelihood(counted, run.sources);
}

// Nothing where no replay runs.
std::optional<Judged> judged(ReplayConfig config) {
  try {
    ReplayOptions options = replay_options(config);
    options.longest = WholeLog::kLongest;
    options.smoother = SmootherKind::kNone;
    const Recording recording = read_recording(config);
    options.filter = with_attitude_sigmas(std::move(options.filter), recording.attitude);
    const Replay run = replay(thinned(condition(recording, options.conditioning)), options);
    const Solution& filtered = run.filtered.solution;
    if (filtered.empty()) return std::nullopt;
    return Judged{std::move(config), diagnosed(run.log, run.options, options.heading, run.found, filtered, nullptr),
                  likelihood_of(run.log, filtered)};
  } catch (const Error&) {
    return std::nullopt;
  }
}

using Calibrations = std::vector<std::optional<Calibration>>;

Calibrations calibrations_of(const Inspection& found) {
  Calibrations all;
  for (const InspectedLog& log : found.logs) all.push_back(log.calibration);
  return all;
}

void set_calibrations(Inspection& found, const Calibrations& all) {
  for (std::size_t i = 0; i < all.size(); ++i) found.logs[i].calibration = all[i];
}

// The logs of the receivers that a configuration uses, in its order.
std::vector<InspectedLog*> receivers_of(Inspection& found) {
  std::vector<InspectedLog*> all;
  for (InspectedLog& log : found.logs) {
    if (log.is(LogKind::kGnss) && log.gnss_health && log.left_out.empty()) all.push_back(&log);
  }
  return all;
}

bool same(const std::optional<PositionDrift>& a, const std::optional<PositionDrift>& b) {
  return a.has_value() == b.has_value() && (!a || (a->sigma == b->sigma && a->of_stated == b->of_stated &&
                                                   a->correlation_time == b->correlation_time));
}

// Makes the calibrations state what a cause changes. Returns false where they cannot.
bool apply(const LikelierCause& cause, const ReplayConfig& config, Inspection& found) {
  if (!cause.change || found.calibration() == nullptr) return false;
  StatedModel model{.options = config.filter, .scales = {}};
  for (const LogFile& file : config.gnss) model.scales.push_back(file.sigma_scales);
  const FilterOptions before = model.options;
  cause.change(model);
  const std::vector<InspectedLog*> receivers = receivers_of(found);
  if (receivers.size() != model.scales.size()) return false;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    std::optional<Calibration>& calibration = receivers[i]->calibration;
    if (!calibration || !calibration->fits()) continue;
    const GnssOptions &now = model.options.gnss[i], &old = before.gnss[i];
    calibration->sigma_scales = model.scales[i];
    if (!same(now.drift, old.drift)) {
      calibration->drift = now.drift;
      calibration->drift_by = DriftBy::kMotion;
    }
    calibration->sway = now.lever_arm_sway;
    if (now.lever_arm != old.lever_arm) calibration->lever_arm = now.lever_arm;
    if (now.velocity_delay && now.velocity_delay != old.velocity_delay && calibration->velocity_delay_sigma > 0)
      calibration->velocity_delay += *now.velocity_delay - old.delay_of_velocity();
    calibration->sensor = model.options.sensor;
    calibration->clock_offset += model.clock_offset;
    calibration->clock_drift += model.clock_drift;
  }
  return true;
}

}  // namespace

void take_causes(Inspection& found, const std::function<ReplayConfig(const Inspection&)>& configured,
                 const ProgressCallback& progress) {
  found.rounds.clear();
  std::optional<Judged> now = judged(configured(found));
  if (!now) return;
  found.rounds.push_back({.verdict = verdict_line(now->diagnosis.verdict)});
  while (found.rounds.size() < kReplays) {
    const std::vector<LikelierCause> causes = now->diagnosis.causes;
    const double least = std::log(static_cast<double>(std::max<std::size_t>(1, causes.size()))) + 3;
    const Calibrations before = calibrations_of(found);
    std::optional<Judged> better;
    for (std::size_t i = 0; i < std::min(kMostTried, causes.size()) && !better; ++i) {
      if (!apply(causes[i], now->config, found)) continue;
      better = judged(configured(found));
      if (better && better->likelihood - now->likelihood > least) {
        found.rounds.back().taken = causes[i].text;
        found.rounds.back().gain = better->likelihood - now->likelihood;
      } else {
        better.reset();
        set_calibrations(found, before);
      }
    }
    if (progress) progress(static_cast<double>(found.rounds.size()) / static_cast<double>(kReplays));
    if (!better) return;
    now = std::move(better);
    found.rounds.push_back({.verdict = verdict_line(now->diagnosis.verdict)});
  }
}

}  // namespace piste
