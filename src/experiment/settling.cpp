#include "experiment/settling.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "piste/core/error.h"
#include "piste/core/state_table.h"
#include "piste/experiment/replay.h"
#include "tune/evidence.h"

namespace piste {
namespace {

constexpr double kWhole = 3600;  // s of the log: an hour has seen what there is to see
constexpr int kMostRounds = 10;
constexpr double kRefused = 0.01;  // of the fixes: ten times what the gate refuses where the sigmas are right
constexpr double kLeastStep = 1.2, kMostStep = 2;  // times the sigmas in a round
constexpr double kStill = 0.25;                    // sigmas: a clock that moves by less stays
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

// What `replay` is told by the configuration of this calibration.
FilterOptions told(FilterOptions options, const Calibration& found, bool delayed) {
  options.sensor = found.sensor;
  GnssOptions& gnss = options.gnss.front();
  if (found.tells_arm()) gnss.lever_arm = found.lever_arm;
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
                                   bool find_clock, Calibration found) {
  const bool delayed = find_clock;
  const auto filtered = [&]() -> std::optional<Solution> {
    ReplayOptions replayed{.conditioning = conditioning,
                           .filter = told(options, found, delayed),
                           .longest = kWhole,
                           .smoother = SmootherKind::kNone,
                           .history = false};
    replayed.conditioning.imu.clock_offset = found.clock_offset;
    replayed.conditioning.imu.clock_drift = found.clock_drift;
    replayed.filter.vehicle = vehicle;
    replayed.filter.estimate = with_implied_blocks(replayed.filter, replayed.filter.estimate);
    Recording scaled = recording;
    scale_sigmas(scaled.gnss.front(), found.sigma_scale, found.sigma_velocity_scale);
    try {
      Solution run = replay(scaled, replayed).filtered.solution;
      if (!run.empty()) return run;
    } catch (const Error&) {  // no start, or a filter that diverges
    }
    return std::nullopt;
  };
  std::optional<Calibration> before;  // the clock moved, if that is what the last round did
  double likelihood = 0;              // the logarithm of a fix's, in the last round
  for (int round = 0; round < kMostRounds; ++round) {
    const auto run = filtered();
    if (!run && before) return before;
    if (!run) return std::nullopt;
    const double now = log_likelihood(run->innovations, run->sources) / static_cast<double>(run->innovations.size());
    if (before && now < likelihood - kAlike) {
      found = *std::exchange(before, std::nullopt);
      find_clock = false;
      continue;
    }
    before.reset();
    likelihood = now;
    if (find_clock) {
      const std::size_t last = run->size() - 1;
      const double delay = run->estimate(last).gnss_delay;
      const Calibration here = found;
      found.clock_sigma = run->sigmas(last).blocks(full_offset(Block::kGnssDelay));
      if (std::abs(delay) > kStill * found.clock_sigma) {
        before = here;
        found.clock_offset -= delay;
        if (found.velocity_delay_sigma > 0) found.velocity_delay -= delay;  // they are where they were
        continue;
      }
    }
    const double position = growth(*run, "gnss[0].position"), velocity = growth(*run, "gnss[0].velocity");
    if (position == 1 && velocity == 1) return found;
    found.sigma_scale *= position;
    if (found.drift) found.drift->sigma *= position;
    found.sigma_velocity_scale *= velocity;
  }
  return found;
}

}  // namespace piste
