#include "alignment_fit.h"

#include <algorithm>
#include <utility>

#include "alignment_epochs.h"

namespace piste {
namespace {

// The noise of the residuals at x. It stays as it was where there are too few residuals.
ResidualNoise measured_noise(const FilteredPair& pair, const AlignmentState& x,
                             const std::vector<AlignmentEpoch>& epochs, ResidualNoise noise) {
  // Smaller residuals [rad/s], [m/s²] are rounding errors: no sensor is so quiet.
  constexpr double kQuietestGyro = 1e-7, kQuietestAccel = 1e-6;
  for (const bool moving : {true, false}) {
    const LeftOver left = left_over(pair, x, epochs, moving);
    const double gyro = robust_sigma(left.gyro), accel = robust_sigma(left.accel);
    if (gyro > 0) noise.gyro[moving] = std::max(gyro, kQuietestGyro);
    if (accel > 0) noise.accel[moving] = std::max(accel, kQuietestAccel);
  }
  return noise;
}

void weigh(std::vector<AlignmentEpoch>& epochs, const ResidualNoise& noise) {
  for (AlignmentEpoch& e : epochs) {
    e.gyro_sigma = noise.gyro[e.moving];
    e.accel_sigma = noise.accel[e.moving];
  }
}

std::vector<AlignmentEpoch> marked_epochs(const SignalPair& signals, const FilteredPair& pair,
                                          const AlignmentState& x) {
  std::vector<AlignmentEpoch> epochs = epochs_in_common(signals, pair, x);
  mark_motion(pair, x, epochs);
  return epochs;
}

AlignmentFit solved_twice(const FilteredPair& pair, const ImuSensor& sensor, AlignmentFit fit) {
  for (int round = 0; round < 2; ++round) {
    weigh(fit.epochs, fit.noise);
    fit.information = solve_alignment(pair, fit.epochs, sensor, fit.x);
    fit.noise = measured_noise(pair, fit.x, fit.epochs, fit.noise);
  }
  return fit;
}

}  // namespace

LeftOver left_over(const FilteredPair& pair, const AlignmentState& x, const std::vector<AlignmentEpoch>& epochs,
                   bool moving) {
  LeftOver left;
  for (const AlignmentEpoch& e : epochs) {
    if (e.moving != moving) {
      left.gyro.push_back({Vector3d::Zero(), 0});
      left.accel.push_back({Vector3d::Zero(), 0});
      continue;
    }
    const AlignmentResidual r = residual(pair, x, e.sample);
    left.gyro.push_back({r.gyro, e.usable.gyro});
    left.accel.push_back({r.accel, e.usable.accel});
  }
  return left;
}

AlignmentFit fit_alignment(const SignalPair& signals, const FilteredPair& pair, const ImuSensor& sensor,
                           const AlignmentFit& start) {
  return solved_twice(pair, sensor, {start.x, start.noise, marked_epochs(signals, pair, start.x)});
}

WhitenedFit fit_whitened(const SignalPair& signals, const FilteredPair& pair, const ImuSensor& sensor,
                         const AlignmentFit& fit) {
  const LeftOver left = left_over(pair, fit.x, fit.epochs, true);
  const Whitening gyro = autoregression(left.gyro, fit.noise.gyro[1]),
                  accel = autoregression(left.accel, fit.noise.accel[1]);
  FilteredPair white = whitened(pair, gyro, accel);
  std::vector<AlignmentEpoch> epochs = marked_epochs(signals, white, fit.x);
  const ResidualNoise noise = measured_noise(white, fit.x, epochs, fit.noise);
  AlignmentFit solved = solved_twice(white, sensor, {fit.x, noise, std::move(epochs)});
  return {std::move(white), std::move(solved), gyro, accel};
}

}  // namespace piste
