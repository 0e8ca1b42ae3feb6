#include "search/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "core/recording.h"
#include "math/parallel.h"
#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "piste/math/statistics.h"
#include "piste/start/start.h"
#include "piste/tune/likeliest_noise.h"
#include "piste/tune/standing_heights.h"
#include "tune/evidence.h"
#include "tune/thinned.h"

namespace piste {
namespace {

constexpr double kArmPrior = 2, kDelayPrior = 0.1, kLeastArm = 0.05, kLeastDelay = 0.003;  // m, s
// Where nothing is known of the lever arm, fixes of centimetres are first taken for coarser ones: the filter would
// otherwise reject what its own first guess makes of them.
constexpr std::array kFloors{0.2, 0.05, 0.0};           // m and m/s
constexpr double kSureClock = 0.02, kRoughClock = 0.1;  // s
constexpr double kLoose = 5;                            // times the sigma that a stage found
constexpr double kHeld = 0.005, kHeldStep = 0.02;  // s: 1-sigma of a delay that is held, and how far these are apart
constexpr double kAstray = 0.1;  // of the logarithm of a row's likelihood: filters that went astray lost 0.4 and more
// s: farther than a turn is like itself. Wrong clocks differ by 0.3 of that likelihood by chance: one that is likelier
// than so many others is hardly a wrong one.
constexpr std::array kFarOff{-20.0, -14.0, -10.0, -7.0, -5.0, 5.0, 7.0, 10.0, 14.0, 20.0};
constexpr double kOverstated = 0.3;  // of the sigmas of positions: as far as these are off at least
constexpr double kWideGate = 1 - 1e-9;
// Offsets of the clock that are tried, s: where nothing is known of it, and where rests determine it to a second.
constexpr double kFarthest = 0.5, kFarthestTold = 3, kStep = 0.1;
constexpr double kApart = 120;  // s between two stretches of motion that determine the drift of a clock
constexpr double kSureDrift = 4, kLeastChange = 0.005;  // sigmas, and s over the log

// s: the clock is at most that far from the configured one.
double unsure(double clock_sigma) {
  return std::isfinite(clock_sigma) ? std::min(kFarthestTold, kLoose * clock_sigma) : kFarthest;
}

// Offsets that are tried to either side.
int steps_within(double unsure, double step) { return unsure > step ? static_cast<int>(std::ceil(unsure / step)) : 0; }

// Delays that are held, to either side.
int held_steps(double unsure) { return static_cast<int>(std::ceil(std::min(unsure, kDelayPrior) / kHeldStep)); }

// How many runs Calibrator::locate() makes one after the other.
double attempts_of(double unsure, std::size_t jobs) {
  constexpr double kOneByOne = 5;  // finer floors, refined, once more as configured
  const double offsets = 2 * steps_within(unsure, kStep) + 1;
  return cost_of_runs(offsets, 1, jobs) + kOneByOne + 2 * held_steps(unsure) + 1;
}

/// One filtered run and how likely its innovations are.
struct Attempt {
  double likelihood = -std::numeric_limits<double>::infinity();  // a row
  double rows = 0;
  double offset = 0;
  Start start;
  Estimate last;
  FullError sigmas = FullError::Zero();  // of its blocks
  std::size_t used = 0, rejected = 0;
  double nis = 1;  // of positions, the mean for a row

  double total() const { return rows * likelihood; }
  double clock_offset() const { return offset - last.gnss_delay; }
  double clock_sigma() const { return sigmas(full_offset(Block::kGnssDelay)); }
  bool fits() const { return rejected < (used + rejected) / 10; }  // as Calibration::fits()
  double velocity_delay() const { return last.velocity_delay - last.gnss_delay; }
  double velocity_delay_sigma() const { return sigmas(full_offset(Block::kVelocityDelay)); }
};

class Calibrator {
 public:
  Calibrator(const Recording& recording, ConditioningOptions conditioning, FilterOptions options,
             const Interval& stretch, double clock_sigma, double arm_prior, std::size_t jobs)
      : recording_(recording),
        conditioning_(std::move(conditioning)),
        options_(std::move(options)),
        gate_(options_.behaviour.trust.gate),
        jobs_(jobs),
        unsure_(unsure(clock_sigma)) {
    for (const Block b : {Block::kLeverArm, Block::kGnssDelay}) {
      if (!options_.estimates(b)) options_.estimate.push_back(b);
    }
    // What is wrong here is the set-up, and not a receiver: none is left out for long.
    options_.behaviour.trust.gate = kWideGate;
    options_.behaviour.trust.distrust = 1;
    options_.priors.lever_arm = arm_prior;
    options_.priors.gnss_delay = std::clamp(kLoose * clock_sigma, kSureClock, kDelayPrior);
    conditioning_.span = stretch;
  }

  // The maximum-likelihood clock and lever arm with the sensor as configured; nothing if no candidate starts.
  std::optional<Attempt> locate(const ProgressCallback& progress = {}) {
    const double configured = conditioning_.imu.clock_offset;
    const FilterOptions at_first = options_;
    take_fixes(kFloors.front());
    const int steps = steps_within(unsure_, kStep);
    std::vector<Attempt> attempts(static_cast<std::size_t>(2 * steps + 1));
    const double all = attempts_of(unsure_, jobs_), together = cost_of_runs(1, 1, jobs_);
    double done = 0;
    std::mutex mutex;
    const auto report = [&](double more) {
      if (!progress) return;
      const std::lock_guard lock(mutex);
      progress((done += more) / all);
    };
    for_each_parallel(attempts.size(), jobs_, [&](std::size_t k) {
      attempts[k] = attempt(configured + (static_cast<double>(k) - steps) * kStep);
      report(together);
    });
    spread_ = spread_of(attempts);
    for (Attempt& a : attempts) keep(std::move(a));
    if (!std::isfinite(best_.likelihood)) return std::nullopt;
    for (const double floor : kFloors) {
      if (floor == kFloors.front()) continue;
      go_finer(floor);
      if (!std::isfinite(best_.likelihood)) return std::nullopt;
      report(1);
    }
    refine();
    report(1);
    // Coarse fixes may have led to another heading, from where no finer ones lead back.
    FilterOptions led = std::exchange(options_, at_first);
    options_.behaviour.trust.gate = gate_;
    options_.priors.gnss_delay = kSureClock;
    const bool again = keep(attempt(configured));
    report(1);
    const bool held = keep_closely_held(configured, report);
    if (again || held) {
      refine();
    } else {
      options_ = std::move(led);
    }
    return best_;
  }

  // The noise that is to be expected with the set-up that was found. Nothing changes where a run that finds its own
  // start with it is less likely.
  // `stated`: the sigmas of positions that the receiver states, by those of the recording. @pre locate()
  void search_noise(double stated, const ProgressCallback& progress = {}) {
    const FilterOptions options_before = options_;
    const Attempt before = best_;
    ConditioningOptions conditioning = conditioning_;
    conditioning.imu.clock_offset = best_.offset;
    try {
      const Tuning found =
          likeliest_noise(condition(fixes_, conditioning), options_, best_.start,
                          {.jobs = jobs_, .thorough = false, .stated = {Vector3d::Constant(stated)}}, progress);
      options_.sensor = found.expected.sensor;
      noise_ = found.expected.gnss.front();
      options_.gnss.front().drift = noise_->process();
      options_.estimate = with_implied_blocks(options_, options_.estimate);
      take_fixes(0);
      best_ = {};
      if (keep(attempt(before.offset)) && best_.likelihood > before.likelihood) return;
    } catch (const DataError&) {  // the innovations determine nothing
    }
    noise_.reset();
    options_ = options_before;
    best_ = before;
    take_fixes(0);
  }

  // Whether the fixes are less likely with clocks that are far apart: where they are as likely, a wrong clock may have
  // been found, which other states make up for. @pre locate()
  bool tells_clock() const {
    const auto as_likely = [this](double off) {
      return attempt(best_.offset + off).likelihood > best_.likelihood - kAstray;
    };
    return std::none_of(kFarOff.begin(), kFarOff.end(), as_likely);
  }

  // The time over which the receiver's velocities are means, where one of these is likelier beyond doubt. @pre locate()
  void find_averaging(const ProgressCallback& progress = {}) {
    double& averaging = options_.gnss.front().velocity_averaging;
    const bool some =
        std::ranges::any_of(recording_.gnss.front().fixes, [](const auto& fix) { return fix.velocity.has_value(); });
    if (!some || !options_.gnss.front().use_velocity || averaging > 0) return;
    const double least = best_.total() + std::log(kAveragingTimes.size() + 1.0) + 3;
    double found = 0, most = least;
    for (const double time : kAveragingTimes) {
      averaging = time;
      if (Attempt a = attempt(best_.offset); a.total() > most) {
        most = a.total();
        found = time;
      }
      if (progress) progress(time / kAveragingTimes.back());
    }
    averaging = found;
    if (found == 0) return;
    best_ = attempt(best_.offset);
    refine();
  }

  // What the sigmas of positions are to be multiplied by so that they say what positions differ by. @pre locate()
  double position_scale() const { return std::sqrt(best_.nis); }

  // What has been found. @pre locate()
  Calibration calibration() {
    refine();
    options_.sensor.name = "likeliest in motion";
    return Calibration{.lever_arm = best_.last.lever_arm,
                       .lever_arm_sigma = best_.sigmas.segment<3>(full_offset(Block::kLeverArm)),
                       .clock_offset = best_.clock_offset(),
                       .clock_sigma = std::hypot(best_.clock_sigma(), spread()),
                       .clock_spread = spread(),
                       .clock_drift = conditioning_.imu.clock_drift,
                       .velocity_delay = late_velocities() ? best_.velocity_delay() : 0,
                       .velocity_delay_sigma = late_velocities() ? best_.velocity_delay_sigma() : 0,
                       .velocity_averaging = options_.gnss.front().velocity_averaging,
                       .sensor = options_.sensor,
                       .sigma_scales = noise_ ? noise_->scales() : SigmaScales{},
                       .drift = options_.gnss.front().drift,
                       .drift_by = noise_ ? drift_by(*noise_) : DriftBy::kRounding,
                       .used = best_.used,
                       .rejected = best_.rejected};
  }

 private:
  // Whether their delay is estimated.
  bool late_velocities() const { return options_.estimates(Block::kVelocityDelay); }

  // 1-sigma of the offsets that the attempts found, each as likely as its fixes (a mixture of normal densities).
  static double spread_of(const std::vector<Attempt>& attempts) {
    double best = -std::numeric_limits<double>::infinity(), weight = 0, mean = 0, square = 0;
    for (const Attempt& a : attempts) best = std::max(best, a.total());
    for (const Attempt& a : attempts) {
      if (!std::isfinite(a.likelihood)) continue;
      const double w = std::exp(a.total() - best), more = a.clock_offset() - mean;
      weight += w;
      mean += w / weight * more;
      square += w * more * (a.clock_offset() - mean);
    }
    return weight > 0 ? std::sqrt(square / weight) : 0;
  }

  // Where the finer fixes leave the clock unsure, the first attempts show which others are as likely.
  double spread() const { return best_.clock_sigma() > kSureClock ? spread_ : 0; }

  Attempt attempt(double offset) const {
    Attempt a;
    a.offset = offset;
    ConditioningOptions conditioning = conditioning_;
    conditioning.imu.clock_offset = offset;
    try {
      const Log log = thinned(condition(fixes_, conditioning));
      a.start = find_start(log, options_, {}).start;
      const Evidence run = filter_again(log, options_, a.start);
      a.last = run.last;
      a.sigmas = run.sigmas;
      for (const Innovation& i : run.innovations) ++(was_used(i.outcome) ? a.used : a.rejected);
      a.nis = nis_of_positions(run.innovations, run.sources);
      a.rows = run.rows;
      if (run.rows > 0) a.likelihood = run.likelihood / run.rows;
    } catch (const Error&) {  // no start: not likely at all
    }
    return a;
  }

  // Where no rest determines the biases, a filter may go astray with delay, heading and biases all unknown. So it is
  // tried with the delay held at several values about the configured one. Returns whether one of them is far more
  // likely than what was found before, and keeps it then.
  template <class Report>
  bool keep_closely_held(double configured, const Report& report) {
    const Priors loose = options_.priors;
    const Attempt before = best_;
    (late_velocities() ? options_.priors.velocity_delay : options_.priors.gnss_delay) = kHeld;
    const int steps = held_steps(unsure_);
    for (int k = -steps; k <= steps; ++k) {
      keep(attempt(configured + k * kHeldStep));
      report(1);
    }
    if (best_.likelihood > before.likelihood + kAstray) return true;
    best_ = before;
    options_.priors = loose;
    return false;
  }

  // Goes on from the estimates with coarser fixes, with fixes no finer than `floor` [m, m/s].
  void go_finer(double floor) {
    const Attempt coarser = best_;
    options_.behaviour.trust.gate = gate_;
    options_.gnss.front().lever_arm = coarser.last.lever_arm;
    options_.priors.lever_arm = std::clamp(kLoose * coarser.sigmas.segment<3>(full_offset(Block::kLeverArm)).maxCoeff(),
                                           kLeastArm, options_.priors.lever_arm);
    options_.priors.gnss_delay = std::clamp(kLoose * coarser.clock_sigma(), kLeastDelay, options_.priors.gnss_delay);
    if (late_velocities()) {
      options_.gnss.front().velocity_delay = coarser.velocity_delay();
      options_.priors.velocity_delay =
          std::clamp(kLoose * coarser.velocity_delay_sigma(), kLeastDelay, options_.priors.velocity_delay);
    }
    take_fixes(floor);
    best_ = {};
    keep(attempt(coarser.clock_offset()));
  }

  void take_fixes(double floor) {
    fixes_ = recording_;
    if (noise_) scale_sigmas(fixes_.gnss.front().fixes, noise_->scales());
    for (GeodeticFix& fix : fixes_.gnss.front().fixes) {
      fix.sigma_position = fix.sigma_position.cwiseMax(floor);
      if (fix.velocity) fix.velocity->sigma = fix.velocity->sigma.cwiseMax(floor);
    }
  }

  // Again from what was found, so that it is linearised there.
  void refine() {
    options_.gnss.front().lever_arm = best_.last.lever_arm;
    if (late_velocities()) options_.gnss.front().velocity_delay = best_.velocity_delay();
    keep(attempt(best_.clock_offset()));
  }

  bool keep(Attempt a) {
    if (a.likelihood <= best_.likelihood) return false;
    best_ = std::move(a);
    return true;
  }

  const Recording& recording_;
  Recording fixes_;  // its copy, with the floor of the stage
  ConditioningOptions conditioning_;
  FilterOptions options_;
  double gate_;  // as configured
  std::optional<ReceiverNoise> noise_;
  std::size_t jobs_;
  double unsure_;      // s: the clock is at most that far from the configured one
  double spread_ = 0;  // s
  Attempt best_;
};

constexpr const char *kClockStage = "clock and lever arm", *kNoiseStage = "noise in motion";

// What the steps of calibrated() cost, in rows that are filtered once.
struct CalibrationCosts {
  CalibrationCosts(const Recording& recording, const ToldClock& clock, std::size_t jobs) {
    constexpr double kAttempt = 1.2;  // it conditions the log, and finds the start with a multiple-model heading search
    const std::vector<GeodeticFix>& fixes = recording.gnss.front().fixes;
    const double seconds = kFirstMotion + 2 * kBeforeMotion, rows = rows_in(recording, seconds);
    const bool apart = fixes.size() > 1 && fixes.back().time - fixes.front().time > kFirstMotion + kApart;
    locate = kAttempt * rows * attempts_of(unsure(clock.sigma), jobs);
    check = clock.sigma <= kRoughClock || clock.with_drift ? 0 : kAttempt * rows * static_cast<double>(kFarOff.size());
    noise = cost_of_search(recording, seconds, jobs);
    drift = clock.with_drift || !apart ? 0 : kAttempt * rows * attempts_of(kSureClock, 1);
    averaging = static_cast<double>(kAveragingTimes.size()) * kAttempt * rows;
  }
  double all() const { return locate + noise + 2 * check + drift; }

  double locate, check, noise, drift, averaging;
};

// By how much the clock drifts more than `first` assumes, from the last minutes of motion; 0 where that is not sure.
double drift_beside(const Recording& recording, const Calibration& first, ConditioningOptions conditioning,
                    FilterOptions options, const Interval& early, const Interval& late, double arm_prior,
                    const ProgressCallback& progress) {
  const double between = (late.start + late.end - early.start - early.end) / 2;
  if (between < kApart) return 0;
  conditioning.imu.clock_offset = first.clock_offset;
  options.gnss.front().lever_arm = first.lever_arm;
  const double unsure = between * kMostClockDrift > kDelayPrior ? kDelayPrior : kSureClock;
  if (first.velocity_delay_sigma > 0) {  // by the IMU's clock, which is what drifts
    options.gnss.front().velocity_delay = first.velocity_delay;
    options.priors.velocity_delay = std::hypot(first.velocity_delay_sigma, unsure);
  }
  const auto there =
      Calibrator(recording, std::move(conditioning), std::move(options), late, unsure, arm_prior, 1).locate(progress);
  if (!there || !there->fits()) return 0;
  const double change = there->clock_offset() - first.clock_offset;
  const double least = std::max(kLeastChange, kSureDrift * std::hypot(first.clock_sigma, there->clock_sigma()));
  return std::abs(change) > least && std::abs(change) < kMostClockDrift * between ? change / between : 0;
}

// As calibrate(), with the errors of the receiver as `recording` and `options` state them.
std::optional<Calibration> calibrated(const Recording& recording, ConditioningOptions conditioning,
                                      FilterOptions options, const ToldClock& clock, Antenna antenna, std::size_t jobs,
                                      const Work& work) {
  const CalibrationCosts costs(recording, clock, jobs);
  const double arm_prior = antenna == Antenna::kInHousing ? kHousing : kArmPrior;
  const Interval motion = motion_of(recording.gnss.front().fixes, options.behaviour.start);
  const Interval early{motion.start - kBeforeMotion, std::min(motion.start + kFirstMotion, motion.end + kBeforeMotion)};
  const Interval late{std::max(motion.start, motion.end - kFirstMotion), motion.end};
  const auto is_told = [&clock](const Calibrator& calibrator) {
    return clock.sigma <= kRoughClock || clock.with_drift || calibrator.tells_clock();
  };
  Recording less_stated;  // with smaller sigmas of positions, where those of the receiver are far too large
  double stated = 1;      // these sigmas, by those of the receiver
  std::optional<Calibrator> beginning(std::in_place, recording, conditioning, options, early, clock.sigma, arm_prior,
                                      jobs);
  if (!beginning->locate(work.step(kClockStage, costs.locate))) return std::nullopt;
  work.step(kClockStage, costs.check);
  if (!is_told(*beginning)) {
    stated = beginning->position_scale();
    if (stated > kOverstated) return std::nullopt;
    work.expect_more(costs.locate);
    less_stated = recording;
    scale_sigmas(less_stated.gnss.front().fixes, {.position = stated});
    beginning.emplace(less_stated, conditioning, options, early, clock.sigma, arm_prior, jobs);
    if (!beginning->locate(work.step(kClockStage, costs.locate)) || !is_told(*beginning)) return std::nullopt;
  }
  work.expect_more(costs.averaging);
  beginning->find_averaging(work.step(kClockStage, costs.averaging));
  beginning->search_noise(1 / stated, work.step(kNoiseStage, costs.noise));
  work.step(kClockStage, costs.check);
  // By chance a wrong clock may be likelier than all that are far off; with the noise that explains it, they are as
  // likely.
  if (!is_told(*beginning)) return std::nullopt;
  // In a housing the prior determines where the antenna is: the replay, which has it too, is to start from it.
  const auto calibration_of = [antenna, stated](Calibrator& calibrator) {
    Calibration all = calibrator.calibration();
    all.sigma_scales.position *= stated;
    all.in_housing = antenna == Antenna::kInHousing;
    if (all.in_housing) all.lever_arm.setZero();
    return all;
  };
  Calibration first = calibration_of(*beginning);
  if (!first.fits() || clock.with_drift) return first;
  // From here on with the noise that was found.
  options.sensor = first.sensor;
  options.gnss.front().drift = first.drift;
  options.gnss.front().velocity_averaging = first.velocity_averaging;
  options.estimate = with_implied_blocks(options, options.estimate);
  Recording scaled = recording;
  scale_sigmas(scaled.gnss.front().fixes, first.sigma_scales);
  const double drift = drift_beside(scaled, first, conditioning, options, early, late, arm_prior,
                                    work.step("drift of the clock", costs.drift));
  if (drift == 0) return first;
  // The offset is that of the first row.
  conditioning.imu.clock_drift += drift;
  conditioning.imu.clock_offset =
      first.clock_offset - drift * ((early.start + early.end) / 2 - (recording.imu.time.front() - first.clock_offset));
  Calibrator drifting(scaled, std::move(conditioning), std::move(options), early, first.clock_sigma, arm_prior, jobs);
  work.expect_more(costs.locate);
  if (!drifting.locate(work.step(kClockStage, costs.locate))) return first;
  Calibration again = calibration_of(drifting);
  if (!again.fits()) return first;
  again.sigma_scales = first.sigma_scales;
  return again;
}

}  // namespace

Interval motion_of(const std::vector<GeodeticFix>& fixes, const StartOptions& options) {
  if (fixes.empty()) return {};
  const auto away_from = [&](const GeodeticFix& end) {
    const World world(end.position);
    return [world, &options](const GeodeticFix& fix) {
      return world.from_geodetic(fix.position).head<2>().norm() >
             options.departed + options.departed_sigmas * fix.sigma_position.head<2>().maxCoeff();
    };
  };
  const auto first = std::find_if(fixes.begin(), fixes.end(), away_from(fixes.front()));
  const auto last = std::find_if(fixes.rbegin(), fixes.rend(), away_from(fixes.back()));
  if (first == fixes.end() || last == fixes.rend()) return {fixes.front().time, fixes.back().time};
  return {first->time, last->time};
}

double rows_in(const Recording& recording, double seconds) {
  const std::vector<double>& time = recording.imu.time;
  if (time.size() < 2) return 0;
  const double length = time.back() - time.front();
  return static_cast<double>(time.size()) * (length > 0 ? std::min(1.0, seconds / length) : 1);
}

double cost_of_search(const Recording& recording, double seconds, std::size_t jobs) {
  const bool again = standing_heights(recording.gnss.front().fixes).slow > 0;
  return cost_of_runs(again ? 2 * kRoughRuns : kRoughRuns, rows_in(recording, seconds), jobs);
}

double cost_of_calibration(const Recording& recording, const ToldClock& clock, std::size_t jobs) {
  return CalibrationCosts(recording, clock, jobs).all();
}

std::optional<Calibration> calibrate(const Recording& recording, ConditioningOptions conditioning,
                                     FilterOptions options, const ToldClock& clock, Antenna antenna, std::size_t jobs,
                                     const Work& work) {
  auto all = calibrated(recording, conditioning, options, clock, antenna, jobs, work);
  const std::vector<GeodeticFix>& fixes = recording.gnss.front().fixes;
  const StandingHeights standing = standing_heights(fixes);
  if (standing.slow == 0) return all;
  std::vector<double> sigmas;
  sigmas.reserve(fixes.size());
  for (const GeodeticFix& fix : fixes) sigmas.push_back(fix.sigma_position.z());
  const double stated = median(std::move(sigmas));
  if (all && all->fits()) {
    const bool coloured = all->drift && all->drift_by == DriftBy::kMotion;
    if (coloured || !standing.too_small(all->sigma_scales.position * all->sigma_scales.height * stated)) return all;
  }
  // Here too, so that likelihoods with and without what is sought are of the same fixes.
  const SigmaScales larger{.height = std::max(1.0, standing.sigma() / stated)};
  Recording rounded = recording;
  scale_sigmas(rounded.gnss.front().fixes, larger);
  options.gnss.front().drift = standing.process();
  options.estimate = with_implied_blocks(options, options.estimate);
  work.expect_more(cost_of_calibration(recording, clock, jobs));
  auto found = calibrated(rounded, std::move(conditioning), std::move(options), clock, antenna, jobs, work);
  if (found) found->sigma_scales.height *= larger.height;
  return found;
}

}  // namespace piste
