#include "study/timing_effect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "piste/core/error.h"

namespace piste {
namespace {

// A slow swing and a vibration on every axis; the reference comes late.
AlignedImus late_by(double delay, double scale) {
  constexpr double kTurn = 2 * std::numbers::pi;
  AlignedImus imus;
  imus.interval = 0.01;
  const auto signal = [](double t) {
    const double value = 3 * std::sin(kTurn * 0.2 * t) + std::sin(kTurn * 7 * t + 1) - 5;
    return Vector3d::Constant(value);
  };
  for (int k = 0; k < 10000; ++k) {  // whole periods of both
    const double t = 0.01 * k;
    imus.time.push_back(t);
    imus.accel.emplace_back((1 + scale) * signal(t) + Vector3d(0.1, 0.2, 0.3));
    imus.gyro.push_back(imus.accel.back());
    imus.reference_accel.push_back(signal(t - delay));
    imus.reference_gyro.push_back(imus.reference_accel.back());
    imus.usable.push_back(1);
  }
  return imus;
}

TEST(TimingEffect, IsTheLossOfCorrelationOfTheSpectrum) {
  for (const double delay : {0.0, 5e-3, 10e-3, 15e-3}) {
    const TimingEffect effect = timing_effect(late_by(delay, 0.02), {0, 100}, delay);
    // Σ S (1 − cos 2πfd) / Σ S of both sines
    const double loss = (9 * (1 - std::cos(2 * std::numbers::pi * 0.2 * delay)) +
                         1 * (1 - std::cos(2 * std::numbers::pi * 7 * delay))) /
                        10;
    EXPECT_EQ(effect.delay, delay);
    for (std::size_t axis = 0; axis < kSignals; ++axis) {
      EXPECT_NEAR(effect.reverse[axis], 1.02 * (1 - loss) - 1, 1e-9);
      EXPECT_NEAR(effect.forward[axis], 1.02 / (1 - loss) - 1, 1e-9);
    }
  }
}

TEST(TimingEffect, NeedsSamplesThatMove) {
  AlignedImus imus = late_by(0, 0);
  EXPECT_THROW(timing_effect(imus, {200, 300}, 0), DataError);
  for (Vector3d& rate : imus.gyro) rate.x() = 1;
  EXPECT_THROW(timing_effect(imus, {0, 100}, 0), DataError);
}

}  // namespace
}  // namespace piste
