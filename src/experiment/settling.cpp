#include "experiment/settling.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "experiment/calibration.h"
#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "piste/experiment/replay.h"
#include "piste/experiment/tune.h"
#include "tune/evidence.h"

namespace piste {
namespace {

constexpr double kWhole = 3600;  // s of the log: an hour has seen what there is to see
constexpr double kTuned = 900;   // s of motion that noise is sought in
constexpr double kMuchMore = 2;  // times the motion that was searched before: less is not searched again
constexpr int kMostRounds = 10;
constexpr double kRefused = 0.01;  // of the fixes: ten times what the gate refuses where the sigmas are right
constexpr double kLeastStep = 1.2, kMostStep = 2;  // times the sigmas in a round
constexpr double kStill = 0.25;                    // sigmas: a clock that moves by less stays
constexpr double kPlausibleDrift = 3.5e-4;         // of a clock: loggers were 14 to 310 ppm off
constexpr double kToldDrift = 0.5;                 // of its prior: a drift that is no better known is not told
constexpr double kRight = 1.2;                     // mean NIS of positions that fit
constexpr double kElsewhere = 5;                   // sigmas of the run that presumes less: no chance in a thousand logs
constexpr std::size_t kFew = 20;                   // of fewer fixes no share is told
constexpr double kAlike = 0.03;  // of the logarithm of a fix's likelihood: as the delay is estimated, more is no chance

// By what factor the sigmas of a source have to grow so that all but a hundredth of its fixes are within the gate; 1 if
// they are.
double growth(const Solution& run, const std::string& source) {
  std::vector<double> beyond;  // nis over its gate
  std::size_t refused = 0;
  for (const Innovation& i : run.innovations) {
    if (run.sources[static_cast<std::size_t>(i.source)] != source || i.gate <= 0) continue;
    if (i.outcome == Outcome::kRepeated) continue;
    beyond.push_back(i.nis / i.gate);
    refused += i.outcome != Outcome::kUsed;
  }
  if (beyond.size() < kFew || static_cast<double>(refused) <= kRefused * static_cast<double>(beyond.size())) return 1;
  const auto last = beyond.begin() + static_cast<std::ptrdiff_t>((1 - kRefused) * static_cast<double>(beyond.size()));
  std::nth_element(beyond.begin(), last, beyond.end());
  return std::clamp(std::sqrt(*last), kLeastStep, kMostStep);
}

// Whether a run knows the drift of the clock better than before it.
bool tells_drift(const Solution& run, const Priors& before) {
  return run.sigmas(run.size() - 1).blocks(full_offset(Block::kClockDrift)) < kToldDrift * before.clock_drift;
}

// Takes the clock from a run that estimates its offset, and its drift if it `drifts`. Returns whether it has moved.
bool take_clock(const Solution& run, bool drifts, Calibration& found) {
  const Estimate x = run.estimate(run.size() - 1);
  const FullError sigmas = run.sigmas(run.size() - 1).blocks;
  found.clock_sigma = sigmas(full_offset(Block::kGnssDelay));
  found.clock_drift_sigma = drifts ? sigmas(full_offset(Block::kClockDrift)) : 0;
  if (std::abs(x.gnss_delay) <= kStill * found.clock_sigma &&
      std::abs(x.clock_drift) <= kStill * found.clock_drift_sigma) {
    return false;
  }
  found.clock_offset -= x.gnss_delay;
  found.clock_drift += x.clock_drift;
  if (found.velocity_delay_sigma > 0) found.velocity_delay = x.velocity_delay - x.gnss_delay;
  return true;
}

std::vector<Innovation> of_positions(const Solution& run) {
  std::vector<Innovation> all;
  std::copy_if(run.innovations.begin(), run.innovations.end(), std::back_inserter(all), [&](const Innovation& i) {
    return run.sources[static_cast<std::size_t>(i.source)] == "gnss[0].position" && i.outcome != Outcome::kRepeated;
  });
  return all;
}

// The logarithm of the likelihood of one of the innovations, as a mean.
double mean_likelihood(const std::vector<Innovation>& innovations, const Solution& run) {
  return log_likelihood(innovations, run.sources) / static_cast<double>(std::max<std::size_t>(1, innovations.size()));
}

// Mean of the NIS of positions, for each of their rows. None counts for more than an outlier.
double nis_of_positions(const Solution& run) {
  constexpr double kOutlier = 10;
  double sum = 0, rows = 0;
  for (const Innovation& i : of_positions(run)) {
    sum += std::min(i.nis, kOutlier * i.dof);
    rows += i.dof;
  }
  return rows > 0 ? sum / rows : 0;
}

// Whether a block ends far from where it ends in a run that presumes less, by the sigmas of that.
bool elsewhere(Block block, const Solution& with, const Solution& without) {
  const auto last = [](const Solution& run) { return run.estimate(run.size() - 1); };
  const FullError sigmas = without.sigmas(without.size() - 1).blocks;
  const FullError apart = boxminus(last(with), last(without));
  const auto part = [&](const FullError& e) { return e.segment(full_offset(block), info(block).size).array(); };
  return (part(apart).abs() > kElsewhere * part(sigmas)).any();
}

SigmaScales product(const SigmaScales& a, const SigmaScales& b) {
  return {.position = a.position * b.position, .height = a.height * b.height, .velocity = a.velocity * b.velocity};
}

// A log and how it is replayed.
struct WholeLog {
  const Recording& recording;
  const ConditioningOptions& conditioning;
  const FilterOptions& options;
  std::optional<VehicleOptions> vehicle;
  bool delayed, drifts = delayed, velocities = true;  // what is estimated, and used

  // What `replay` is told by the configuration of a calibration.
  FilterOptions told(const Calibration& found) const {
    FilterOptions filter = options;
    filter.sensor = found.sensor;
    filter.vehicle = vehicle;
    GnssOptions& gnss = filter.gnss.front();
    if (found.tells_arm()) gnss.lever_arm = found.lever_arm;
    gnss.drift = found.drift;
    gnss.use_velocity = gnss.use_velocity && velocities;
    filter.estimate = imu_error_blocks(found.sensor);
    filter.estimate.push_back(Block::kLeverArm);
    if (delayed) filter.estimate.push_back(Block::kGnssDelay);
    if (drifts) filter.estimate.push_back(Block::kClockDrift);
    if (found.velocity_delay_sigma > 0 && gnss.use_velocity) {
      gnss.velocity_delay = found.velocity_delay;
      filter.estimate.push_back(Block::kVelocityDelay);
    }
    filter.priors = priors_after(found, filter.priors);
    filter.estimate = with_implied_blocks(filter, filter.estimate);
    return filter;
  }

  ReplayOptions replayed(const Calibration& found) const {
    ReplayOptions all{.conditioning = conditioning,
                      .filter = told(found),
                      .longest = kWhole,
                      .smoother = SmootherKind::kNone,
                      .history = false};
    all.conditioning.imu.clock_offset = found.clock_offset;
    all.conditioning.imu.clock_drift = found.clock_drift;
    return all;
  }
  Recording scaled(const Calibration& found) const {
    Recording all = recording;
    scale_sigmas(all.gnss.front().fixes, found.sigma_scales);
    return all;
  }

  // Nothing where no filter runs.
  std::optional<Solution> filtered(const Calibration& found) const {
    try {
      Solution run = replay(scaled(found), replayed(found)).filtered.solution;
      if (!run.empty()) return run;
    } catch (const Error&) {  // no start, or a filter that diverges
    }
    return std::nullopt;
  }

  // With the noise that is to be expected by a quarter of an hour of motion; nothing where that tells none.
  std::optional<Calibration> tuned(Calibration found, const Interval& motion, std::size_t jobs) const {
    ReplayOptions run = replayed(found);
    run.conditioning.span = {motion.start - kBeforeMotion, std::min(motion.start + kTuned, motion.end + kBeforeMotion)};
    try {
      const TuneOptions how{
          .jobs = jobs, .try_drift = false, .thorough = false, .stated = 1 / found.sigma_scales.position};
      const NoiseModel noise = tune(scaled(found), run, how).expected;
      found.sensor = noise.sensor;
      found.drift = noise.gnss.front().process();
      found.sigma_scales = product(found.sigma_scales, noise.gnss.front().scales());
      return found;
    } catch (const Error&) {  // no start, or no innovations
      return std::nullopt;
    }
  }
};

}  // namespace

std::optional<Calibration> settled(const Recording& recording, const ConditioningOptions& conditioning,
                                   const FilterOptions& options, const std::optional<VehicleOptions>& vehicle,
                                   bool find_clock, Calibration found) {
  WholeLog log{recording, conditioning, options, vehicle, find_clock};
  std::optional<Calibration> before;  // the clock moved, if that is what the last round did
  double likelihood = 0;              // the logarithm of a fix's, in the last round
  for (int round = 0; round < kMostRounds; ++round) {
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
        before = here;
        continue;
      }
    }
    const double position = growth(*run, "gnss[0].position"), velocity = growth(*run, "gnss[0].velocity");
    if (position == 1 && velocity == 1) return found;
    found.sigma_scales.position *= position;
    if (found.drift) found.drift->sigma *= position;
    found.sigma_scales.velocity *= velocity;
  }
  return found;
}

bool drifts_plausibly(const Calibration& found) { return std::abs(found.clock_drift) < kPlausibleDrift; }

std::optional<Calibration> retuned(const Recording& recording, const ConditioningOptions& conditioning,
                                   const FilterOptions& options, const std::optional<VehicleOptions>& vehicle,
                                   bool find_clock, const Calibration& found, std::size_t jobs) {
  const Interval motion = motion_of(recording.gnss.front().fixes, options.behaviour.start);
  if (motion.end - motion.start < kMuchMore * kFirstMotion) return std::nullopt;
  const WholeLog log{recording, conditioning, options, vehicle, find_clock, found.clock_drift_sigma > 0};
  const auto tuned = log.tuned(found, motion, jobs);
  const auto run = tuned ? log.filtered(*tuned) : std::nullopt;
  if (!run || mean_likelihood(run->innovations, *run) <= found.likelihood) return std::nullopt;
  auto again = settled(recording, conditioning, options, vehicle, find_clock, *tuned);
  if (again && drifts_plausibly(*again)) return again;
  return std::nullopt;
}

bool velocities_contradict(const Recording& recording, const ConditioningOptions& conditioning,
                           const FilterOptions& options, const std::optional<VehicleOptions>& vehicle, bool find_clock,
                           const Calibration& found) {
  const std::vector<GeodeticFix>& fixes = recording.gnss.front().fixes;
  const bool some = std::any_of(fixes.begin(), fixes.end(), [](const GeodeticFix& fix) { return fix.velocity; });
  if (!some || !options.gnss.front().use_velocity) return false;
  if (!drifts_plausibly(found)) return true;
  WholeLog log{recording, conditioning, options, vehicle, find_clock, found.clock_drift_sigma > 0};
  const auto with = log.filtered(found);
  log.velocities = false;
  const auto without = log.filtered(found);
  if (!with || !without) return false;
  // Few positions may lead a filter astray, which tells nothing.
  if (nis_of_positions(*without) > std::max(kRight, nis_of_positions(*with))) return false;
  return elsewhere(Block::kLeverArm, *with, *without) || (find_clock && elsewhere(Block::kGnssDelay, *with, *without));
}

bool vehicle_contradicts(const Recording& recording, const ConditioningOptions& conditioning,
                         const FilterOptions& options, const VehicleOptions& vehicle, bool find_clock,
                         const Calibration& found) {
  WholeLog log{recording, conditioning, options, vehicle, find_clock, found.clock_drift_sigma > 0};
  const auto with = log.filtered(found);
  log.vehicle.reset();
  const auto without = log.filtered(found);
  if (!with || !without) return false;
  return elsewhere(Block::kGyroScale, *with, *without) || elsewhere(Block::kAccelScale, *with, *without);
}

}  // namespace piste
