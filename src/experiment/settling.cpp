#include "experiment/settling.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "piste/experiment/replay.h"

namespace piste {
namespace {

constexpr double kWhole = 3600;  // s of the log: an hour has seen what there is to see
constexpr int kMostRounds = 6;
constexpr double kRefused = 0.01;  // of the fixes: ten times what the gate refuses where the sigmas are right
constexpr double kLeastStep = 1.2, kMostStep = 2;  // times the sigmas in a round
constexpr double kStill = 0.25;                    // sigmas: a clock that moves by less stays
constexpr std::size_t kFew = 20;                   // of fewer fixes no share is told

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

// What `replay` is told by the configuration of this calibration.
FilterOptions told(FilterOptions options, const Calibration& found, bool delayed) {
  options.sensor = found.sensor;
  GnssOptions& gnss = options.gnss.front();
  gnss.lever_arm = found.lever_arm;
  gnss.drift = found.drift;
  options.estimate = imu_error_blocks(found.sensor);
  options.estimate.push_back(Block::kLeverArm);
  if (delayed) options.estimate.push_back(Block::kGnssDelay);
  if (found.velocity_delay_sigma > 0) {
    gnss.velocity_delay = found.velocity_delay;
    options.estimate.push_back(Block::kVelocityDelay);
  }
  options.priors = priors_after(found, options.priors);
  options.estimate = with_implied_blocks(options, options.estimate);
  return options;
}

}  // namespace

std::optional<Calibration> settled(const Recording& recording, const ConditioningOptions& conditioning,
                                   const FilterOptions& options, const std::optional<VehicleOptions>& vehicle,
                                   const GnssHealth& receiver, bool find_clock, Calibration found) {
  for (int round = 0;; ++round) {
    ReplayOptions replayed{.conditioning = conditioning,
                           .filter = told(options, found, find_clock && clock_matters(found, receiver)),
                           .longest = kWhole,
                           .smoother = SmootherKind::kNone,
                           .history = false};
    replayed.conditioning.imu.clock_offset = found.clock_offset;
    replayed.conditioning.imu.clock_drift = found.clock_drift;
    replayed.filter.vehicle = vehicle;
    replayed.filter.estimate = with_implied_blocks(replayed.filter, replayed.filter.estimate);
    Recording scaled = recording;
    scale_sigmas(scaled.gnss.front(), found.sigma_scale, found.sigma_velocity_scale);
    Solution run;
    try {
      run = replay(scaled, replayed).filtered.solution;
    } catch (const Error&) {
      return std::nullopt;
    }
    if (run.empty()) return std::nullopt;
    if (round == kMostRounds) return found;
    const double position = growth(run, "gnss[0].position"), velocity = growth(run, "gnss[0].velocity");
    found.sigma_scale *= position;
    if (found.drift) found.drift->sigma *= position;
    found.sigma_velocity_scale *= velocity;
    const std::size_t last = run.size() - 1;
    const Estimate x = run.estimate(last);
    const FullError sigmas = run.sigmas(last).blocks;
    if (replayed.filter.estimates(Block::kGnssDelay)) {
      found.clock_offset -= x.gnss_delay;
      found.clock_sigma = sigmas(full_offset(Block::kGnssDelay));
    }
    if (position == 1 && velocity == 1 && std::abs(x.gnss_delay) < kStill * found.clock_sigma) return found;
  }
}

}  // namespace piste
