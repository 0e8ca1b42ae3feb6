#include "walker/sample_noise.h"

#include <cmath>
#include <numbers>

#include "piste/math/statistics.h"

namespace piste {

HiddenExcess hidden_excess(double range, double mean, double share) {
  const double room = range - mean, quantile = normal_quantile(1 - share);
  const double sigma = quantile * range > room ? room / quantile : range;
  const double alpha = room / sigma;
  const double density = std::exp(-0.5 * alpha * alpha) / std::sqrt(2 * std::numbers::pi);
  const double lambda = density / (0.5 * std::erfc(alpha / std::numbers::sqrt2));
  return {sigma * (lambda - alpha), sigma * sigma * (1 + alpha * lambda - lambda * lambda)};
}

// What a clipped sample hides, with the sign of its value; nothing of another sample.
HiddenExcess SampleNoise::Axis::add(double value, bool clips, bool moves, double range) {
  const double side = value < 0 ? -1 : 1;
  double& beyond = clipped[value < 0 ? 0 : 1];
  if (moves || clips) {
    ++count;
    sum += value;
    if (clips) ++beyond;
  }
  in_a_row = clips ? in_a_row + 1 : 0;
  if (!clips) return {};
  HiddenExcess hidden = hidden_excess(range, side * sum / count, (beyond + 0.5) / (count + 1));
  hidden.mean *= side;
  hidden.variance *= 2 * in_a_row - 1;
  return hidden;
}

ClippedNoise SampleNoise::of(const ImuSample& sample, const ImuSensor& sensor) {
  ClippedNoise out{{sensor.gyro.noise_variance(), sensor.accel.noise_variance()}};
  const bool measured = !sample.gap && !sample.interpolated, moves = measured && !sample.at_rest;
  const auto add = [&](std::size_t axis, double value, bool clips, double range, double& hidden, double& density) {
    const HiddenExcess excess = axes_[axis].add(value / sample.interval, clips, moves, range);
    hidden = excess.mean;
    density += excess.variance * sample.interval;
  };
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    add(axis, sample.dtheta(i), (sample.clipped_gyro >> i) & 1, sensor.gyro.range, out.hidden_rate(i),
        out.noise.gyro(i));
    add(3 + axis, sample.dvel(i), (sample.clipped_accel >> i) & 1, sensor.accel.range, out.hidden_force(i),
        out.noise.accel(i));
  }
  for (const MaybeNoise& added : {sample.gap, sample.interpolated}) {
    if (!added) continue;
    out.noise.accel.array() += square(added->accel);
    out.noise.gyro.array() += square(added->gyro);
  }
  return out;
}

}  // namespace piste
