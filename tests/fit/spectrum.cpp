// Power at the right frequency, and all of it.

#include "fit/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "support/random.h"

namespace piste {
namespace {

double integral(const Spectrum& s, int axis) {
  double sum = 0;
  for (const Vector3d& d : s.density) sum += d(axis);
  return sum * s.frequency[1];
}

TEST(Spectrum, WhiteNoiseIsFlatAtItsDensity) {
  test::Random random(1);
  const double dt = 0.01, density = 0.02;  // as a sensor file says it
  std::vector<Vector3d> noise(40'000);
  for (Vector3d& v : noise) v = random.vector(density / std::sqrt(dt));
  const Spectrum s = welch(noise, {}, dt, 512);
  EXPECT_EQ(s.frequency.size(), 257U);
  EXPECT_DOUBLE_EQ(s.frequency.back(), 50);
  EXPECT_EQ(s.segments, 155);
  // Segments under a Hann window that overlap by half are worth 18/19 of independent ones.
  const Band band = chi_squared_band(1 - 1e-6, 2, 18.0 / 19 * s.segments);
  for (std::size_t k = 2; k + 2 < s.frequency.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_TRUE(band.contains(s.density[k](axis) / (2 * density * density))) << s.frequency[k] << " Hz";
    }
  }
}

TEST(Spectrum, HoldsAllThePower) {
  test::Random random(2);
  const double dt = 0.005;
  std::vector<Vector3d> signal(8192);
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const double phase = 2 * std::numbers::pi * 17 * dt * static_cast<double>(i);
    signal[i] = Vector3d(3 * std::sin(phase) + 100, random.gaussian(2), -5);
  }
  const Spectrum s = welch(signal, {}, dt, 1024);
  EXPECT_NEAR(integral(s, 0), 4.5, 0.01) << "of a tone of amplitude 3, and not of the mean";
  EXPECT_NEAR(integral(s, 1), 4, 0.3);
  EXPECT_NEAR(integral(s, 2), 0, 1e-20);
  std::size_t peak = 0;
  for (std::size_t k = 0; k < s.density.size(); ++k) {
    if (s.density[k].x() > s.density[peak].x()) peak = k;
  }
  EXPECT_NEAR(s.frequency[peak], 17, 0.1);

  // One segment alone: Parseval to rounding, for any signal.
  std::vector<Vector3d> part(64);
  for (Vector3d& v : part) v = random.vector();
  Vector3d mean = Vector3d::Zero(), weighted = Vector3d::Zero();
  for (const Vector3d& v : part) mean += v / 64;
  double power = 0;
  for (std::size_t i = 0; i < 64; ++i) {
    const double w = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / 64);
    power += w * w;
    weighted += (w * (part[i] - mean)).cwiseAbs2();
  }
  const Spectrum one = welch(part, {}, dt, 64);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(integral(one, axis), weighted(axis) / power, 1e-12);
}

TEST(Spectrum, LeavesOutWhatIsNotUsable) {
  test::Random random(3);
  std::vector<Vector3d> signal(1000);
  for (Vector3d& v : signal) v = random.vector();
  std::vector<std::uint8_t> usable(1000, 1);
  signal[500] = Vector3d(1e9, 1e9, 1e9);
  usable[500] = 0;
  const Spectrum s = welch(signal, usable, 0.01, 100);
  EXPECT_EQ(s.segments, 17);
  EXPECT_NEAR(integral(s, 0), 1, 0.2);
  std::fill(usable.begin(), usable.end(), std::uint8_t{0});
  EXPECT_THROW(welch(signal, usable, 0.01, 100), DataError);
  EXPECT_THROW(welch(signal, {}, 0.01, 2000), DataError);
}

}  // namespace
}  // namespace piste
