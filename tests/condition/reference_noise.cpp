// Two MEMS-IMUs on one plate, in motion that is calm beside their noise: the reference's noise neither shortens the
// lever arm nor makes anything look better known than it is.

#include "condition/reference_noise.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdio>

#include "piste/configuration/sensor_file.h"
#include "piste/math/statistics.h"
#include "support/imu_pair.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

// As on the axle and the dashboard of a car: 41 cm apart.
Scenario calm_pair(std::uint64_t seed) {
  Scenario s = pair_scenario("montecarlo/gentle_lap", seed, 10, 150);
  s.imus[1].sensor = s.imus[0].sensor;
  s.imus[1].rate = s.imus[0].rate;
  s.imus[1].sampling = s.imus[0].sampling;
  s.imus[0].p_rb_r = Vector3d(-0.318, -0.092, 0.175);
  s.motion.balance_rate *= 1.5;
  s.motion.vibration_rate *= 1.5;
  return s;
}

TEST(ReferenceNoise, ErrorsAreWhatCovariancesClaim) {
  const int runs = seeds(3, 24);
  Vector8d squares = Vector8d::Zero(), mean = Vector8d::Zero(), sigma = Vector8d::Zero();
  double nees = 0;
  for (int run = 1; run <= runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(run);
    const ImuPair pair = simulate_pair(calm_pair(seed), seed);
    const Alignment a =
        align(pair.body, pair.reference, {.sensor = pair.setup.sensor, .reference = pair.reference_sensor});
    ASSERT_TRUE(a.undetermined.empty()) << a.undetermined.front();
    const Vector8d e = alignment_error(a, pair.setup);
    const Matrix8d P = a.covariance.topLeftCorner<8, 8>();
    nees += e.dot(P.ldlt().solve(e)) / (8 * runs);
    squares += (e.cwiseAbs2().array() / P.diagonal().array()).matrix() / runs;
    mean += e / runs;
    sigma += P.diagonal().cwiseSqrt() / runs;
  }
  // No wider than they need be by more than twice: scales of the reference are in them as if they were independent.
  const Band each = chi_squared_band(0.999, 1, runs), all = chi_squared_band(0.999, 8, runs);
  for (int i = 0; i < 8; ++i) {
    std::printf("%d: mean error %.3g, sigma %.3g, mean square over variance %.2f\n", i, mean(i), sigma(i), squares(i));
    EXPECT_LT(squares(i), each.high) << i;
    EXPECT_LT(std::abs(mean(i)), 4 * sigma(i) / std::sqrt(runs)) << i;
  }
  std::printf("NEES %.3f\n", nees);
  EXPECT_LT(nees, all.high);
  EXPECT_GT(nees, 0.25);
  for (int i = 5; i < 8; ++i) EXPECT_LT(sigma(i), 0.01) << i;
}

// Without a sensor file of the reference nothing is taken back.
TEST(ReferenceNoise, ShortensALeverArmThatItIsNotTakenBackFrom) {
  const ImuPair pair = simulate_pair(calm_pair(1), 1);
  const Alignment a = align(pair.body, pair.reference, {.sensor = pair.setup.sensor});
  std::printf("%.3f m of %.3f m, sigma %.4f m\n", a.p_rb_r.norm(), pair.setup.p_rb_r.norm(),
              a.sigma(AlignmentLayout::kLeverArm).maxCoeff());
  EXPECT_LT(a.p_rb_r.norm() + 10 * a.sigma(AlignmentLayout::kLeverArm).maxCoeff(), pair.setup.p_rb_r.norm());
}

}  // namespace
}  // namespace piste::test
