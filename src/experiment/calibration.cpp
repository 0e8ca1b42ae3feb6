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
constexpr double kLoose = 5;                   // times the sigma that a stage found
constexpr double kWideGate = 1 - 1e-9;
constexpr double kFarthest = 0.5, kStep = 0.1;  // s: offsets of the clock that are tried
constexpr double kMostGates = 2;
constexpr int kRounds = 2;
constexpr double kSignificant = 3;  // of the log-likelihood: by chance a value gains half of one

/// One filtered run and how likely its innovations are.
struct Attempt {
  double likelihood = -std::numeric_limits<double>::infinity();  // a row
  double offset = 0;
  FoundStart found;
  Estimate last;
  Sigmas sigmas;
  std::size_t used = 0, rejected = 0;
  double rows = 0;
};

class Calibrator {
 public:
  Calibrator(const Recording& recording, ConditioningOptions conditioning, FilterOptions options)
      : recording_(recording),
        conditioning_(std::move(conditioning)),
        options_(std::move(options)),
        gate_(options_.behaviour.trust.gate) {
    for (const Block b : {Block::kLeverArm, Block::kGnssDelay}) {
      if (std::find(options_.estimate.begin(), options_.estimate.end(), b) == options_.estimate.end())
        options_.estimate.push_back(b);
    }
    // What is wrong here is the set-up, and not a receiver: none is left out for long.
    options_.behaviour.trust.gate = kWideGate;
    options_.behaviour.trust.distrust = 1;
    options_.priors.lever_arm = kArmPrior;
    options_.priors.gnss_delay = kDelayPrior;
    conditioning_.span = stretch();
  }

  std::optional<Calibration> run(bool search_clock) {
    const double told = conditioning_.imu.clock_offset;
    take_fixes(kFloors.front());
    const int steps = search_clock ? static_cast<int>(std::lround(kFarthest / kStep)) : 0;
    for (int k = -steps; k <= steps; ++k) keep(attempt(told + k * kStep, options_.sensor, nullptr));
    if (!std::isfinite(best_.likelihood)) return std::nullopt;
    for (const double floor : kFloors) {
      if (floor == kFloors.front()) continue;
      go_finer(floor);
      if (!std::isfinite(best_.likelihood)) return std::nullopt;
    }
    refine();
    search_noise();
    refine();
    options_.sensor.name = "likeliest in motion";
    return Calibration{.lever_arm = best_.last.lever_arm,
                       .lever_arm_sigma = best_.sigmas.blocks.segment<3>(full_offset(Block::kLeverArm)),
                       .clock_offset = best_.offset - best_.last.gnss_delay,
                       .clock_sigma = best_.sigmas.blocks(full_offset(Block::kGnssDelay)),
                       .sensor = options_.sensor,
                       .used = best_.used,
                       .rejected = best_.rejected};
  }

 private:
  // The first minutes of motion, by the receiver.
  Interval stretch() const {
    const auto& fixes = recording_.gnss.front().fixes;
    if (fixes.empty()) return {};
    const World world(fixes.front().position);
    double from = fixes.front().time;
    for (const GeodeticFix& fix : fixes) {
      if (world.from_geodetic(fix.position).head<2>().norm() < 2 + 6 * fix.sigma_position.head<2>().maxCoeff())
        continue;
      from = std::max(from, fix.time - kBefore);
      break;
    }
    return {from, from + kBefore + kLongest};
  }

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
    options_.priors.gnss_delay = std::clamp(kLoose * told.sigmas.blocks(full_offset(Block::kGnssDelay)), kLeastDelay,
                                            options_.priors.gnss_delay);
    take_fixes(floor);
    best_ = {};
    keep(attempt(told.offset - told.last.gnss_delay, options_.sensor, nullptr));
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
    keep(attempt(best_.offset - best_.last.gnss_delay, options_.sensor, nullptr));
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
  Attempt best_;
};

}  // namespace

std::optional<Calibration> calibrate(const Recording& recording, ConditioningOptions conditioning,
                                     FilterOptions options, bool search_clock) {
  return Calibrator(recording, std::move(conditioning), std::move(options)).run(search_clock);
}

}  // namespace piste
