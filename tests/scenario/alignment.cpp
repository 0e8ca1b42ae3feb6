// Three ski runs and a lap by bicycle, aligned without any prior: the table that docs/alignment.md quotes, of seeds 1
// to 3, held to the bounds that the project set itself, with sigmas that are true and no larger than stated.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <ostream>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "support/imu_pair.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

struct Motion {
  const char* name;
  double offset, drift, boresight, lever_arm;  ///< largest sigmas [s, 1, deg, m]
};

void PrintTo(const Motion& motion, std::ostream* out) { *out << motion.name; }

class AlignmentAccuracy : public testing::TestWithParam<Motion> {};

TEST_P(AlignmentAccuracy, IsWithinItsBounds) {
  Eigen::Matrix<double, 8, 1> worst = Eigen::Matrix<double, 8, 1>::Zero(), sigma = worst;
  double most_sigmas = 0, nees = 0;
  const int runs = seeds(3, 12);
  for (int n = 1; n <= runs; ++n) {
    const auto seed = static_cast<std::uint64_t>(n);
    const ImuPair pair = simulate_pair(pair_scenario(GetParam().name, seed, 20, 90), seed);
    const Alignment a =
        align(pair.body, pair.reference, {.sensor = pair.setup.sensor, .reference = pair.reference_sensor});
    ASSERT_TRUE(a.undetermined.empty()) << a.undetermined.front();
    const Eigen::Matrix<double, 8, 1> e = alignment_error(a, pair.setup).cwiseAbs(),
                                      claimed = a.covariance.diagonal().head<8>().cwiseSqrt();
    worst = worst.cwiseMax(e);
    sigma = sigma.cwiseMax(claimed);
    const Eigen::Matrix<double, 8, 8> P = a.covariance.topLeftCorner<8, 8>();
    nees += alignment_error(a, pair.setup).dot(P.ldlt().solve(alignment_error(a, pair.setup))) / (8 * runs);
    most_sigmas = std::max(most_sigmas, (e.array() / claimed.array()).maxCoeff());
  }
  const double angle = kDegreesPerRadian * worst.segment<3>(2).maxCoeff();
  fmt::print("| {} | {:.3f} ({:.3f}) ms | {:.2f} ({:.2f}) ppm | {:.3f} ({:.3f}) deg | {:.2f} ({:.2f}) mm | {:.1f} |\n",
             GetParam().name, 1e3 * worst(0), 1e3 * sigma(0), 1e6 * worst(1), 1e6 * sigma(1), angle,
             kDegreesPerRadian * sigma.segment<3>(2).maxCoeff(), 1e3 * worst.tail<3>().maxCoeff(),
             1e3 * sigma.tail<3>().maxCoeff(), most_sigmas);
  EXPECT_LT(worst(0), 0.2e-3);
  EXPECT_LT(worst(1), 3e-6);
  EXPECT_LT(angle, 0.02);
  EXPECT_LT(worst.tail<3>().maxCoeff(), 1e-3);
  EXPECT_LT(most_sigmas, 4);
  EXPECT_LT(sigma(0), GetParam().offset);
  EXPECT_LT(sigma(1), GetParam().drift);
  EXPECT_LT(kDegreesPerRadian * sigma.segment<3>(2).maxCoeff(), GetParam().boresight);
  EXPECT_LT(sigma.tail<3>().maxCoeff(), GetParam().lever_arm);
  const Band band = chi_squared_band(0.999, 8, runs);
  EXPECT_TRUE(band.contains(nees)) << nees << " outside " << band.low << " to " << band.high;
}

INSTANTIATE_TEST_SUITE_P(Scenarios, AlignmentAccuracy,
                         testing::Values(Motion{"ski", 0.011e-3, 0.15e-6, 0.011, 0.25e-3},
                                         Motion{"easy_ski", 0.014e-3, 0.19e-6, 0.008, 0.13e-3},
                                         Motion{"giant_slalom", 0.008e-3, 0.12e-6, 0.004, 0.07e-3},
                                         Motion{"bicycle", 0.011e-3, 0.16e-6, 0.011, 0.26e-3}),
                         [](const auto& scenario) { return std::string(scenario.param.name); });

}  // namespace
}  // namespace piste::test
