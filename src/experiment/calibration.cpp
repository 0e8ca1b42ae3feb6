#include "experiment/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/solve/run.h"
#include "piste/solve/start.h"

namespace piste {
namespace {

constexpr double kLongest = 150, kBefore = 30;  // s of motion, and of what comes before it
constexpr double kSettled = 15;                 // s after the start whose innovations tell of the start alone
constexpr double kArmPrior = 2, kDelayPrior = 0.1, kLeastArm = 0.05, kLeastDelay = 0.003;  // m, s
// Where nothing is known of the lever arm, fixes of centimetres are first taken for coarser ones: the filter would
// otherwise reject what its own first guess makes of them.
constexpr std::array kFloors{0.2, 0.05, 0.0};  // m and m/s
constexpr double kSureClock = 0.02;            // s
constexpr double kLoose = 5;                   // times the sigma that a stage found
constexpr double kWideGate = 1 - 1e-9;
constexpr double kFarthest = 0.5, kStep = 0.1;  // s: offsets of the clock that are tried
constexpr double kMostGates = 2;
constexpr int kRounds = 2;
constexpr double kSignificant = 3;  // of the log-likelihood: by chance a value gains half of one
// The drift of a clock: s between two stretches of motion that tell it, and what a crystal may have.
constexpr double kApart = 120, kMostDrift = 3e-4;
constexpr double kSureDrift = 4, kLeastChange = 0.005;  // sigmas, and s over the log

/// One filtered run and how likely its innovations are.
struct Attempt {
  double likelihood = -std::numeric_limits<double>::infinity();  // a row
  double offset = 0;
  FoundStart found;
  Estimate last;
  Sigmas sigmas;
  std::size_t used = 0, rejected = 0;
  double rows = 0;

  double clock_offset() const { return offset - last.gnss_delay; }
  double clock_sigma() const { return sigmas.blocks(full_offset(Block::kGnssDelay)); }
  bool fits() const { return rejected < (used + rejected) / 10; }  // as Calibration::fits()
  double velocity_delay() const { return last.velocity_delay - last.gnss_delay; }
  double velocity_delay_sigma() const { return sigmas.blocks(full_offset(Block::kVelocityDelay)); }
};

// Where a receiver says that the body moves: between departure and arrival, as the start judges a departure.
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

class Calibrator {
 public:
  Calibrator(const Recording& recording, ConditioningOptions conditioning, FilterOptions options,
             const Interval& stretch, double clock_sigma)
      : recording_(recording),
        conditioning_(std::move(conditioning)),
        options_(std::move(options)),
        gate_(options_.behaviour.trust.gate),
        search_clock_(clock_sigma > kSureClock) {
    for (const Block b : {Block::kLeverArm, Block::kGnssDelay}) {
      if (!options_.estimates(b)) options_.estimate.push_back(b);
    }
    // What is wrong here is the set-up, and not a receiver: none is left out for long.
    options_.behaviour.trust.gate = kWideGate;
    options_.behaviour.trust.distrust = 1;
    options_.priors.lever_arm = kArmPrior;
    options_.priors.gnss_delay = std::clamp(kLoose * clock_sigma, kSureClock, kDelayPrior);
    conditioning_.span = stretch;
  }

  // The likeliest clock and lever arm with the sensor as it is told; nothing if no candidate starts.
  std::optional<Attempt> locate() {
    const double told = conditioning_.imu.clock_offset;
    const FilterOptions at_first = options_;
    take_fixes(kFloors.front());
    const int steps = search_clock_ ? static_cast<int>(std::lround(kFarthest / kStep)) : 0;
    for (int k = -steps; k <= steps; ++k) keep(attempt(told + k * kStep, options_.sensor, nullptr));
    if (!std::isfinite(best_.likelihood)) return std::nullopt;
    for (const double floor : kFloors) {
      if (floor == kFloors.front()) continue;
      go_finer(floor);
      if (!std::isfinite(best_.likelihood)) return std::nullopt;
    }
    refine();
    // Coarse fixes may have led to another heading, from where no finer ones lead back.
    FilterOptions led = std::exchange(options_, at_first);
    options_.behaviour.trust.gate = gate_;
    options_.priors.gnss_delay = kSureClock;
    if (keep(attempt(told, options_.sensor, nullptr))) {
      refine();
    } else {
      options_ = std::move(led);
    }
    return best_;
  }

  std::optional<Calibration> run() {
    if (!locate()) return std::nullopt;
    search_noise();
    refine();
    options_.sensor.name = "likeliest in motion";
    return Calibration{.lever_arm = best_.last.lever_arm,
                       .lever_arm_sigma = best_.sigmas.blocks.segment<3>(full_offset(Block::kLeverArm)),
                       .clock_offset = best_.clock_offset(),
                       .clock_sigma = best_.clock_sigma(),
                       .clock_drift = conditioning_.imu.clock_drift,
                       .velocity_delay = late_velocities() ? best_.velocity_delay() : 0,
                       .velocity_delay_sigma = late_velocities() ? best_.velocity_delay_sigma() : 0,
                       .sensor = options_.sensor,
                       .used = best_.used,
                       .rejected = best_.rejected};
  }

 private:
  // Whether their delay is estimated.
  bool late_velocities() const { return options_.estimates(Block::kVelocityDelay); }

  Attempt attempt(double offset, const ImuSensor& sensor, const Start* start) const {
    Attempt a;
    a.offset = offset;
    ConditioningOptions conditioning = conditioning_;
    conditioning.imu.clock_offset = offset;
    FilterOptions options = options_;
    options.sensor = sensor;
    try {
      const Log log = condition(fixes_, conditioning);
      a.found = start != nullptr ? FoundStart{*start, ""} : find_start(log, options, {});
      const Solution solution = run_filter(log, options, a.found.start).solution;
      if (solution.empty()) return a;
      a.last = solution.estimate(solution.size() - 1);
      a.sigmas = solution.sigmas(solution.size() - 1);
      double sum = 0, rows = 0;
      for (const Innovation& i : solution.innovations) {
        if (!solution.sources[static_cast<std::size_t>(i.source)].starts_with("gnss")) continue;
        ++(was_used(i.outcome) ? a.used : a.rejected);
        if (i.time < solution.time(0) + kSettled || i.outcome == Outcome::kRepeated) continue;
        sum -= 0.5 * (std::min(i.nis, kMostGates * i.gate) + i.log_determinant);
        rows += i.dof;
      }
      a.rows = rows;
      if (rows > 0) a.likelihood = sum / rows;
    } catch (const Error&) {
      return a;  // no start, or the filter diverged: not likely at all
    }
    return a;
  }

  // Goes on from what coarser fixes told, with fixes no finer than `floor` [m, m/s].
  void go_finer(double floor) {
    const Attempt told = best_;
    options_.behaviour.trust.gate = gate_;
    options_.gnss.front().lever_arm = told.last.lever_arm;
    options_.priors.lever_arm =
        std::clamp(kLoose * told.sigmas.blocks.segment<3>(full_offset(Block::kLeverArm)).maxCoeff(), kLeastArm,
                   options_.priors.lever_arm);
    options_.priors.gnss_delay = std::clamp(kLoose * told.clock_sigma(), kLeastDelay, options_.priors.gnss_delay);
    if (late_velocities()) {
      options_.gnss.front().velocity_delay = told.velocity_delay();
      options_.priors.velocity_delay =
          std::clamp(kLoose * told.velocity_delay_sigma(), kLeastDelay, options_.priors.velocity_delay);
    }
    take_fixes(floor);
    best_ = {};
    keep(attempt(told.clock_offset(), options_.sensor, nullptr));
  }

  void take_fixes(double floor) {
    fixes_ = recording_;
    for (GeodeticFix& fix : fixes_.gnss.front().fixes) {
      fix.sigma_position = fix.sigma_position.cwiseMax(floor);
      if (fix.velocity) fix.velocity->sigma = fix.velocity->sigma.cwiseMax(floor);
    }
  }

  // Again from what was found, so that it is linearised there.
  void refine() {
    options_.gnss.front().lever_arm = best_.last.lever_arm;
    if (late_velocities()) options_.gnss.front().velocity_delay = best_.velocity_delay();
    keep(attempt(best_.clock_offset(), options_.sensor, nullptr));
  }

  bool keep(Attempt a) {
    if (a.likelihood <= best_.likelihood) return false;
    best_ = std::move(a);
    return true;
  }

  // White noise and drift of both triads, one after the other, by factors that become smaller.
  void search_noise() {
    double factor = 3;
    for (int round = 0; round < kRounds; ++round) {
      bool better = false;
      for (const int which : {1, 0, 3, 2}) {  // vibration shows in the forces first
        for (const double by : {factor, 1 / factor}) {
          bool moved = false;
          while (try_noise(which, by)) moved = true;
          better = better || moved;
          if (moved) break;
        }
      }
      if (!better) factor = std::sqrt(factor);
    }
  }

  bool try_noise(int which, double by) {
    ImuSensor sensor = options_.sensor;
    TriadErrors& triad = which % 2 == 0 ? sensor.gyro : sensor.accel;
    double& value = which < 2 ? triad.noise : triad.drift.sigma;
    value *= by;
    const double least = which % 2 == 0 ? 1e-6 : 1e-5, most = which % 2 == 0 ? 0.1 : 3;
    if (value < least || value > most) return false;
    const Attempt a = attempt(best_.offset, sensor, &best_.found.start);
    if (a.rows * (a.likelihood - best_.likelihood) < kSignificant) return false;
    keep(a);
    options_.sensor = sensor;
    return true;
  }

  const Recording& recording_;
  Recording fixes_;  // its copy, with the floor of the stage
  ConditioningOptions conditioning_;
  FilterOptions options_;
  double gate_;  // as told
  bool search_clock_;
  Attempt best_;
};

// By how much the clock drifts more than `first` was told, from the last minutes of motion; 0 where that is not sure.
double drift_beside(const Recording& recording, const Calibration& first, ConditioningOptions conditioning,
                    FilterOptions options, const Interval& early, const Interval& late) {
  const double between = (late.start + late.end - early.start - early.end) / 2;
  if (between < kApart) return 0;
  conditioning.imu.clock_offset = first.clock_offset;
  options.sensor = first.sensor;
  options.gnss.front().lever_arm = first.lever_arm;
  const double unsure = between * kMostDrift > kDelayPrior ? kDelayPrior : kSureClock;
  const auto there = Calibrator(recording, std::move(conditioning), std::move(options), late, unsure).locate();
  if (!there || !there->fits()) return 0;
  const double change = there->clock_offset() - first.clock_offset;
  const double least = std::max(kLeastChange, kSureDrift * std::hypot(first.clock_sigma, there->clock_sigma()));
  return std::abs(change) > least && std::abs(change) < kMostDrift * between ? change / between : 0;
}

}  // namespace

std::optional<Calibration> calibrate(const Recording& recording, ConditioningOptions conditioning,
                                     FilterOptions options, double clock_sigma) {
  const Interval motion = motion_of(recording.gnss.front().fixes, options.behaviour.start);
  const Interval early{motion.start - kBefore, std::min(motion.start + kLongest, motion.end + kBefore)};
  const Interval late{std::max(motion.start, motion.end - kLongest), motion.end};
  auto first = Calibrator(recording, conditioning, options, early, clock_sigma).run();
  if (!first || !first->fits()) return first;
  const double drift = drift_beside(recording, *first, conditioning, options, early, late);
  if (drift == 0) return first;
  // The offset is that of the first row.
  conditioning.imu.clock_drift += drift;
  conditioning.imu.clock_offset = first->clock_offset - drift * ((early.start + early.end) / 2 -
                                                                 (recording.imu.time.front() - first->clock_offset));
  options.sensor = first->sensor;
  const auto again =
      Calibrator(recording, std::move(conditioning), std::move(options), early, first->clock_sigma).run();
  return again && again->fits() ? again : first;
}

}  // namespace piste
