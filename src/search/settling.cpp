#include "search/settling.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "piste/search/tune.h"
#include "search/calibration.h"
#include "search/contradiction.h"
#include "search/whole_log.h"
#include "tune/evidence.h"

namespace piste {
namespace {

constexpr double kTuned = 900;      // s of motion that noise is sought in
constexpr double kMuchMore = 1.25;  // times the motion that was searched before: less is not searched again
constexpr int kMostRounds = 10;
// Of the fixes, the share that may be refused: ten times what the gate refuses where the sigmas are right. Where most
// of the log has determined the noise, it has seen the worst sky, and long tails are no reason for larger sigmas of all
// the rest.
constexpr double kRefused = 0.01, kRefusedOfTails = 0.03;
constexpr double kLeastStep = 1.2, kMostStep = 2;  // times the sigmas in a round
constexpr double kStill = 0.25;                    // sigmas: a clock that moves by less stays
constexpr double kKnownDrift = 0.5;                // of its prior: a drift that is no better known is not determined
constexpr double kRounds = 5, kRunCost = 1.2;      // rounds as a rule; a run finds its start besides
constexpr const char *kWholeStage = "whole log", *kMotionStage = "noise in all motion";
constexpr std::size_t kFew = 20;  // fewer fixes give no share
constexpr double kAlike = 0.03;  // of the logarithm of a fix's likelihood: as the delay is estimated, more is no chance

// By what factor the sigmas of a source have to grow so that no larger a share of its fixes than `most` is refused; 1
// if none is.
double growth(const Evidence& run, const std::string& source, double most) {
  std::vector<double> beyond;  // nis over its gate
  std::size_t refused = 0;
  for (const Innovation& i : run.innovations) {
    if (run.sources[static_cast<std::size_t>(i.source)] != source || i.gate <= 0) continue;
    if (i.outcome == Outcome::kRepeated) continue;
    beyond.push_back(i.nis / i.gate);
    refused += i.outcome != Outcome::kUsed;
  }
  if (beyond.size() < kFew || static_cast<double>(refused) <= most * static_cast<double>(beyond.size())) return 1;
  const auto last = beyond.begin() + static_cast<std::ptrdiff_t>((1 - most) * static_cast<double>(beyond.size()));
  std::nth_element(beyond.begin(), last, beyond.end());
  return std::clamp(std::sqrt(*last), kLeastStep, kMostStep);
}

// Whether a run knows the drift of the clock better than before it.
bool tells_drift(const Evidence& run, const Priors& before) {
  return run.sigmas(full_offset(Block::kClockDrift)) < kKnownDrift * before.clock_drift;
}

// Takes the clock from a run that estimates its offset, and its drift if it `drifts`. Returns whether it has moved.
bool take_clock(const Evidence& run, bool drifts, Calibration& found) {
  const Estimate& x = run.last;
  found.clock_sigma = std::hypot(run.sigmas(full_offset(Block::kGnssDelay)), found.clock_spread);
  found.clock_drift_sigma = drifts ? run.sigmas(full_offset(Block::kClockDrift)) : 0;
  if (std::abs(x.gnss_delay) <= kStill * found.clock_sigma &&
      std::abs(x.clock_drift) <= kStill * found.clock_drift_sigma) {
    return false;
  }
  found.clock_offset -= x.gnss_delay;
  found.clock_drift += x.clock_drift;
  if (found.velocity_delay_sigma > 0) found.velocity_delay = x.velocity_delay - x.gnss_delay;
  return true;
}

std::vector<Innovation> of_positions(const Evidence& run) {
  std::vector<Innovation> all;
  std::copy_if(run.innovations.begin(), run.innovations.end(), std::back_inserter(all), [&](const Innovation& i) {
    return run.sources[static_cast<std::size_t>(i.source)] == "gnss[0].position" && i.outcome != Outcome::kRepeated;
  });
  return all;
}

// The logarithm of the likelihood of one of the innovations, as a mean.
double mean_likelihood(const std::vector<Innovation>& innovations, const Evidence& run) {
  return log_likelihood(innovations, run.sources) / static_cast<double>(std::max<std::size_t>(1, innovations.size()));
}

SigmaScales product(const SigmaScales& a, const SigmaScales& b) {
  return {.position = a.position * b.position, .height = a.height * b.height, .velocity = a.velocity * b.velocity};
}

Interval motion_of(const WholeLog& log) {
  return motion_of(log.recording.gnss.front().fixes, log.options.behaviour.start);
}

// With the noise that is to be expected by a quarter of an hour of `motion`; nothing where that determines none.
std::optional<Calibration> with_noise_of(const WholeLog& log, Calibration found, const Interval& motion,
                                         std::size_t jobs, const ProgressCallback& progress) {
  ReplayOptions run = log.replayed(found);
  run.conditioning.span = {motion.start - kBeforeMotion, std::min(motion.start + kTuned, motion.end + kBeforeMotion)};
  try {
    const TuneOptions how{.jobs = jobs, .thorough = false, .stated = {stated_before(found.sigma_scales)}};
    const NoiseModel noise = tune(log.scaled(found), run, how, progress).expected;
    found.sensor = noise.sensor;
    found.drift = noise.gnss.front().process();
    found.drift_by = drift_by(noise.gnss.front());
    found.sigma_scales = product(found.sigma_scales, noise.gnss.front().scales());
    return found;
  } catch (const Error&) {  // no start, or no innovations
    return std::nullopt;
  }
}

// As settled(), until no larger a share of the fixes than `refused` is.
std::optional<Calibration> settled_within(double refused, WholeLog log, Calibration found, const Work& work) {
  const ProgressCallback progress = work.step(kWholeStage, cost_of_settling(log));
  bool find_clock = log.find_clock;
  log.drifts = find_clock;
  std::optional<Calibration> before;  // the clock moved, if that is what the last round did
  double likelihood = 0;              // the logarithm of a fix's, in the last round
  std::optional<Calibration> grown;   // with the sigmas before the last growth
  for (int round = 0; round < kMostRounds; ++round) {
    // However many there will be: as if as many as a rule were always still to come.
    if (progress) progress(1 - std::pow(1 - 1 / kRounds, round));
    const auto run = log.filtered(found);
    if (!run && before) return before;
    if (!run) return std::nullopt;
    if (log.drifts && !tells_drift(*run, log.options.priors)) {
      log.drifts = false;
      continue;
    }
    const double now = mean_likelihood(run->innovations, *run);
    if (before && now < likelihood - kAlike) {
      found = *std::exchange(before, std::nullopt);
      find_clock = false;
      continue;
    }
    before.reset();
    likelihood = found.likelihood = now;
    found.likelihood_of_positions = mean_likelihood(of_positions(*run), *run);
    if (find_clock) {
      const Calibration here = found;
      if (take_clock(*run, log.drifts, found)) {
        if (log.drifts && !drifts_plausibly(found)) {  // it is no clock's
          found = here;
          found.clock_drift = 0;
          log.drifts = false;
          continue;
        }
        before = here;
        continue;
      }
    }
    const double position = growth(*run, "gnss[0].position", refused),
                 velocity = growth(*run, "gnss[0].velocity", refused);
    if (grown && now < grown->likelihood) return *grown;  // wider sigmas cost more than the outliers
    if (position == 1 && velocity == 1) return found;
    grown = found;
    found.sigma_scales.position *= position;
    if (found.drift) found.drift->follow(position);
    found.sigma_scales.velocity *= velocity;
  }
  return found;
}

}  // namespace

double cost_of_settling(const WholeLog& log) { return kRounds * kRunCost * rows_in(log.recording, WholeLog::kLongest); }

double cost_of_retuning(const WholeLog& log, std::size_t jobs) {
  const Interval motion = motion_of(log);
  if (motion.end - motion.start < kMuchMore * kFirstMotion) return 0;
  const double searched = std::min(kTuned, motion.end - motion.start) + 2 * kBeforeMotion;
  return cost_of_search(log.recording, searched, jobs) + cost_of_settling(log);
}

std::optional<Calibration> settled(WholeLog log, Calibration found, const Work& work) {
  const Interval motion = motion_of(log);
  const bool seen = motion.end - motion.start <= kFirstMotion;
  return settled_within(seen ? kRefusedOfTails : kRefused, std::move(log), std::move(found), work);
}

std::optional<Calibration> retuned(WholeLog log, const Calibration& found, std::size_t jobs, const Work& work) {
  const Interval motion = motion_of(log);
  if (motion.end - motion.start < kMuchMore * kFirstMotion) return std::nullopt;
  log.drifts = found.clock_drift_sigma > 0;
  const double search = cost_of_retuning(log, jobs) - cost_of_settling(log);
  const auto likelier = with_noise_of(log, found, motion, jobs, work.step(kMotionStage, search));
  if (!likelier) return std::nullopt;
  // Compared after its sigmas have grown, too, as those of `found` have.
  auto again = settled_within(kRefusedOfTails, log, *likelier, work);
  if (again && again->likelihood > found.likelihood && drifts_plausibly(*again)) return again;
  return std::nullopt;
}

}  // namespace piste
