#include "experiment/lever_arm.h"

#include <algorithm>
#include <utility>

#include "piste/experiment/replay.h"

namespace piste {

LeverArmGuess lever_arm(const Recording& recording, const ConditioningOptions& conditioning, FilterOptions options) {
  constexpr double kLongest = 300, kSigma = 2;  // s, m
  if (std::find(options.estimate.begin(), options.estimate.end(), Block::kLeverArm) == options.estimate.end()) {
    options.estimate.push_back(Block::kLeverArm);
  }
  options.priors.lever_arm = kSigma;
  const Replay run = replay(recording, {.conditioning = conditioning,
                                        .filter = std::move(options),
                                        .longest = kLongest,
                                        .smoother = SmootherKind::kNone});
  const Solution& solution = run.solution();
  LeverArmGuess guess;
  const std::size_t last = solution.size() - 1;
  guess.value = solution.estimate(last).lever_arm;
  for (int axis = 0; axis < 3; ++axis) {
    guess.sigma(axis) = solution.sigmas(last).blocks(full_offset(Block::kLeverArm) + axis);
  }
  for (const Innovation& i : solution.innovations) {
    if (!solution.sources[static_cast<std::size_t>(i.source)].starts_with("gnss")) continue;
    ++(i.outcome == Outcome::kRejected ? guess.rejected : guess.used);
  }
  return guess;
}

}  // namespace piste
