// The boresight and the errors of an MT-9A beside a reference attitude, through the programs: ski runs of each kind,
// heading unknown.
//
// The project's bounds are 0.02 deg for the boresight, 0.01 deg/s and 0.01 m/s^2 for the total biases averaged over the
// run, 1200 ppm for the scales. A run cannot hold more than its motion tells: in the gentle one the gyros see 4 to
// 10 deg/s rms, which give the boresight to 0.03 deg and the pitch gyro's scale to 1900 ppm. So what is claimed is held
// to stated values, within a tenth either way, errors to what is claimed, and the RMSE to the bounds on the axes where
// 1.5 of the stated sigmas keep to them.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <ostream>
#include <string_view>

#include "piste/math/statistics.h"
#include "support/mt9a_run.h"
#include "support/thorough.h"
#include "support/yaml.h"

namespace piste::test {
namespace {

constexpr std::size_t kQuantities = 5;
constexpr std::array<const char*, kQuantities> kNames{"boresight", "gyro_total_bias", "accel_total_bias", "gyro_scale",
                                                      "accel_scale"};
constexpr std::array<double, kQuantities> kBounds{0.02, 0.01, 0.01, 1200, 1200};

struct KnownMotion {
  const char* name;
  std::array<Vector3d, kQuantities> sigma;  ///< stated
};

void PrintTo(const KnownMotion& motion, std::ostream* out) { *out << motion.name; }

class Boresight : public testing::TestWithParam<KnownMotion> {};

TEST_P(Boresight, AndTheErrorsOfTheImuAreFound) {
  if (!thorough() && std::string_view(GetParam().name) != "ski") GTEST_SKIP() << "with PISTE_THOROUGH=1";
  struct Sums {
    Vector3d squares = Vector3d::Zero(), variance = Vector3d::Zero(), normalised = Vector3d::Zero();
  };
  std::array<Sums, kQuantities> sums;
  const int runs = seeds(4, 20);
  for (int seed = 1; seed <= runs; ++seed) {
    const Mt9aRun run(GetParam().name, seed);
    run.replay("gnss_l1l2", "", "attitude: {file: run/ln200_attitude.csv, correlation_time: 60 s}\n", ", boresight");
    const YAML::Node summary = run.summary(), estimates = summary["estimates"];
    const YAML::Node truth = run.imu(), gyro = truth["gyro"], accel = truth["accel"];
    const std::array<YAML::Node, kQuantities> found{estimates["boresight"], summary["gyro_total_bias"],
                                                    summary["accel_total_bias"], estimates["gyro_scale"],
                                                    estimates["accel_scale"]};
    const std::array<Vector3d, kQuantities> right{vector_of(truth["boresight_deg"]),
                                                  vector_of(gyro["bias_deg_s"]) + vector_of(gyro["drift_mean_deg_s"]),
                                                  vector_of(accel["bias_m_s2"]) + vector_of(accel["drift_mean_m_s2"]),
                                                  vector_of(gyro["scale_ppm"]), vector_of(accel["scale_ppm"])};
    for (std::size_t q = 0; q < kQuantities; ++q) {
      ASSERT_TRUE(found[q]) << kNames[q];
      const Vector3d sigma = vector_of(found[q]["sigma"]), error = vector_of(found[q]["value"]) - right[q];
      const Vector3d in_sigmas = error.cwiseQuotient(sigma);
      EXPECT_LT(in_sigmas.cwiseAbs().maxCoeff(), 4) << kNames[q] << " of seed " << seed;
      sums[q].squares += error.cwiseAbs2() / runs;
      sums[q].variance += sigma.cwiseAbs2() / runs;
      sums[q].normalised += in_sigmas.cwiseAbs2() / runs;
    }
    EXPECT_LT(summary["attitude"]["rejected"].as<int>(), 0.005 * summary["attitude"]["used"].as<int>()) << seed;
  }
  const Band band = chi_squared_band(0.999, 3, runs);
  for (std::size_t q = 0; q < kQuantities; ++q) {
    const Vector3d rmse = sums[q].squares.cwiseSqrt(), claimed = sums[q].variance.cwiseSqrt();
    const double nees = sums[q].normalised.mean();
    std::printf(
        "%s, %d runs: %-16s RMSE %9.4g %9.4g %9.4g   claimed %9.4g %9.4g %9.4g   NEES %.2f, band %.2f to %.2f\n",
        GetParam().name, runs, kNames[q], rmse.x(), rmse.y(), rmse.z(), claimed.x(), claimed.y(), claimed.z(), nees,
        band.low, band.high);
    EXPECT_LT(nees, band.high) << kNames[q];
    // A total bias is a mean over the run, which is better than its sigma, that of an instant.
    if (!std::string_view(kNames[q]).ends_with("total_bias")) {
      EXPECT_GT(nees, band.low) << kNames[q];
    }
    for (int i = 0; i < 3; ++i) {
      const double stated = GetParam().sigma[q](i);
      EXPECT_NEAR(claimed(i) / stated, 1, 0.1) << kNames[q] << " axis " << i;
      if (1.5 * stated < kBounds[q]) {
        EXPECT_LT(rmse(i), kBounds[q]) << kNames[q] << " axis " << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Runs, Boresight,
    testing::Values(KnownMotion{"ski",
                                {Vector3d(0.030, 0.0222, 0.0257), Vector3d::Constant(0.00515),
                                 Vector3d(0.0071, 0.0058, 0.0096), Vector3d(530, 1830, 550), Vector3d(770, 985, 1110)}},
                    KnownMotion{"easy_ski",
                                {Vector3d(0.0099, 0.0106, 0.0095), Vector3d::Constant(0.00517),
                                 Vector3d(0.0049, 0.0038, 0.0069), Vector3d(213, 425, 218), Vector3d(525, 189, 816)}},
                    KnownMotion{"giant_slalom",
                                {Vector3d(0.0067, 0.0085, 0.0064), Vector3d::Constant(0.0052),
                                 Vector3d(0.0035, 0.0037, 0.0043), Vector3d(153, 195, 159), Vector3d(294, 188, 427)}}),
    [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace piste::test
