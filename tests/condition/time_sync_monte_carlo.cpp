// Alignments of ski and bicycle: their errors are those that their covariances claim, and little more than
// the Cramér-Rao bound of the clock offset.

#include <gtest/gtest.h>

#include <cstdio>

#include "piste/math/statistics.h"
#include "support/imu_pair.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

const int kRuns = seeds(6, 200);
constexpr double kProbability = 0.999;

/// Information about the offset of the clocks, everything else being known: Σ |dw/dt|² / σ_w², and the same of forces,
/// σ being the white noise of one row. The Cramér-Rao bound is its inverse root: σ_w / (√N rms |dw/dt|).
struct OffsetInformation {
  double gyro = 0, accel = 0;
};

OffsetInformation offset_information(const ImuPair& pair) {
  OffsetInformation information;
  const auto& signal = pair.simulated.signal;
  const double dt = 1 / pair.setup.rate;
  const auto row_variance = [&](double density) { return density * density / dt; };
  for (std::size_t k = 1; k + 1 < signal.size(); ++k) {
    const Vector3d w = (signal[k + 1].gyro - signal[k - 1].gyro) / (2 * dt);
    const Vector3d f = (signal[k + 1].accel - signal[k - 1].accel) / (2 * dt);
    information.gyro += w.squaredNorm() / row_variance(pair.setup.sensor.gyro.noise);
    information.accel += f.squaredNorm() / row_variance(pair.setup.sensor.accel.noise);
  }
  return information;
}

class TimeSyncMonteCarlo : public testing::TestWithParam<const char*> {};

TEST_P(TimeSyncMonteCarlo, ErrorsAreWhatCovariancesClaim) {
  Vector8d squares = Vector8d::Zero();
  double nees = 0, offset_squares = 0, gyro_bound = 0, bound = 0, claimed = 0;
  for (int run = 1; run <= kRuns; ++run) {
    const auto seed = static_cast<std::uint64_t>(run);
    const ImuPair pair = simulate_pair(pair_scenario(GetParam(), seed, 5, 45), seed);
    const Alignment a =
        align(pair.body, pair.reference, {.sensor = pair.setup.sensor, .reference = pair.reference_sensor});
    ASSERT_TRUE(a.undetermined.empty()) << a.undetermined.front();
    const Vector8d e = alignment_error(a, pair.setup);
    const Matrix8d P = a.covariance.topLeftCorner<8, 8>();
    nees += e.dot(P.ldlt().solve(e)) / kRuns;
    squares += (e.cwiseAbs2().array() / P.diagonal().array()).matrix() / kRuns;
    // Where offset and drift are not correlated: in the middle of what tells them.
    const double middle = -P(0, 1) / P(1, 1), offset = e(0) + middle * e(1);
    const OffsetInformation information = offset_information(pair);
    offset_squares += offset * offset / kRuns;
    claimed += (P(0, 0) - P(0, 1) * P(0, 1) / P(1, 1)) / kRuns;
    gyro_bound += 1 / information.gyro / kRuns;
    bound += 1 / (information.gyro + information.accel) / kRuns;
  }
  std::printf(
      "%s: NEES %.3f; mean square of error over sigma: offset %.2f drift %.2f boresight %.2f %.2f %.2f "
      "lever arm %.2f %.2f %.2f\n"
      "offset amid the run: RMSE %.2f us, claimed %.2f us; bound %.2f us, of the gyroscopes alone %.2f us\n",
      GetParam(), nees / 8, squares(0), squares(1), squares(2), squares(3), squares(4), squares(5), squares(6),
      squares(7), 1e6 * std::sqrt(offset_squares), 1e6 * std::sqrt(claimed), 1e6 * std::sqrt(bound),
      1e6 * std::sqrt(gyro_bound));
  EXPECT_TRUE(chi_squared_band(kProbability, 8, kRuns).contains(nees / 8)) << nees / 8;
  for (int i = 0; i < 8; ++i) {
    EXPECT_TRUE(chi_squared_band(kProbability, 1, kRuns).contains(squares(i))) << i << ": " << squares(i);
  }
  // The bound knows all but the offset, and a reference without noise.
  const double over = std::sqrt(offset_squares / bound);
  EXPECT_GT(over, 0.8);
  EXPECT_LT(over, 2);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, TimeSyncMonteCarlo, testing::Values("ski", "bicycle"),
                         [](const auto& scenario) { return std::string(scenario.param); });

}  // namespace
}  // namespace piste::test
