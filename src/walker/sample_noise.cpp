#include "walker/sample_noise.h"

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kClippedSpread = 0.2;  // 1-sigma of the excess that clipping hides, as a fraction of the range

}  // namespace

StepNoise SampleNoise::of(const ImuSample& sample, const ImuSensor& sensor) {
  StepNoise noise{sensor.gyro.noise_variance(), sensor.accel.noise_variance()};
  const auto clip = [&](int axis, bool clipped, double range, double& density) {
    int& run = clipped_in_a_row_[static_cast<std::size_t>(axis)];
    run = clipped ? run + 1 : 0;
    const double hidden = kClippedSpread * range;
    if (clipped) density += hidden * hidden * sample.interval * (2 * run - 1);
  };
  for (int i = 0; i < 3; ++i) {
    clip(i, (sample.clipped_gyro >> i) & 1, sensor.gyro.range, noise.gyro(i));
    clip(3 + i, (sample.clipped_accel >> i) & 1, sensor.accel.range, noise.accel(i));
  }
  for (const MaybeNoise& added : {sample.gap, sample.interpolated}) {
    if (!added) continue;
    noise.accel.array() += square(added->accel);
    noise.gyro.array() += square(added->gyro);
  }
  return noise;
}

}  // namespace piste
