#include "piste/sim/sensors.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/sim/random.h"

namespace piste {
namespace {

// Two-sided bounds, at 1e-3, of a sample variance over its true value.
void expect_variance(double sum_of_squares, double sigma, double freedom) {
  const boost::math::chi_squared law(freedom);
  const double statistic = sum_of_squares / (sigma * sigma);
  EXPECT_GT(statistic, boost::math::quantile(law, 5e-4));
  EXPECT_LT(statistic, boost::math::quantile(law, 1 - 5e-4));
}

Truth plate(double rest = 30, double run = 20) {
  MotionOptions motion;
  motion.rest_before = rest;
  motion.run = run;
  motion.rest_after = 10;
  return Truth(World(Geodetic{46.1 * kDegree, 7.2 * kDegree, 2000}), motion, 5, 302400);
}

ImuSetup perfect() {
  ImuSetup setup;
  setup.name = "imu";
  setup.q_rb = from_euler({0.03, -0.02, 0.05});
  setup.p_rb_r = {0.05, 0.02, -0.01};
  return setup;
}

TEST(RandomStream, IsTheSameForTheSameNameOnly) {
  RandomStream a(1, "a"), again(1, "a"), other(1, "b"), seed(2, "a");
  const double first = a.normal();
  EXPECT_EQ(first, again.normal());
  EXPECT_NE(first, other.normal());
  EXPECT_NE(first, seed.normal());
}

TEST(RandomStream, IsNormal) {
  RandomStream random(3, "normal");
  constexpr int kCount = 100000;
  double sum = 0, squares = 0, fourth = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  EXPECT_LT(std::abs(sum / kCount), 3.3 / std::sqrt(kCount));
  expect_variance(squares, 1, kCount);
  EXPECT_NEAR(fourth / kCount, 3, 3.3 * std::sqrt(96.0 / kCount));
}

TEST(DriftPath, GaussMarkovIsStationaryWithItsCorrelation) {
  const DriftProcess process{DriftProcess::Kind::kGaussMarkov, 0.5, 20, 0};
  constexpr int kPaths = 3000;
  double first = 0, last = 0, product = 0;
  for (int i = 0; i < kPaths; ++i) {
    DriftPath path(process, {static_cast<std::uint64_t>(i), "path"});
    const double start = path.value().x();
    for (int k = 0; k < 10; ++k) path.advance(1);
    first += start * start;
    last += path.value().x() * path.value().x();
    product += start * path.value().x();
  }
  expect_variance(first, 0.5, kPaths);
  expect_variance(last, 0.5, kPaths);
  EXPECT_NEAR(product / kPaths, 0.25 * std::exp(-0.5), 3.3 * 0.25 * std::sqrt(2.0 / kPaths));
}

TEST(DriftPath, RandomWalkGrowsWithTheRootOfTime) {
  const DriftProcess process{DriftProcess::Kind::kRandomWalk, 0, 0, 0.2};
  constexpr int kPaths = 2000;
  double squares = 0;
  for (int i = 0; i < kPaths; ++i) {
    DriftPath path(process, {static_cast<std::uint64_t>(i), "walk"});
    EXPECT_EQ(path.value().x(), 0);
    for (int k = 0; k < 5; ++k) path.advance(5);
    squares += path.value().x() * path.value().x();
  }
  expect_variance(squares, 0.2 * 5, kPaths);
}

TEST(SimulateImu, WithoutErrorsIsTheTruth) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  const Truth b = r.attached(setup.q_rb, setup.p_rb_r);
  const SimulatedImu mean = simulate_imu(r, setup, 1);
  setup.sampling = ImuSetup::Sampling::kInstant;
  const SimulatedImu instant = simulate_imu(r, setup, 1);
  setup.sampling = ImuSetup::Sampling::kIncrements;
  const SimulatedImu increments = simulate_imu(r, setup, 1);
  ASSERT_EQ(mean.recording.time.size(), 6000u);
  for (const std::size_t k : {0u, 100u, 4000u}) {
    const double t = mean.recording.time[k];
    EXPECT_NEAR(t, 302400 + 0.01 * static_cast<double>(k + 1), 1e-9);
    EXPECT_LT((mean.recording.gyro[k] - b.mean(t - 0.01, t).gyro).norm(), 1e-8);
    EXPECT_LT((mean.recording.accel[k] - b.mean(t - 0.01, t).accel).norm(), 1e-7);
    EXPECT_LT((instant.recording.accel[k] - b.at(t).f_ib_b).norm(), 1e-7);
    EXPECT_LT((increments.recording.accel[k] - 0.01 * mean.recording.accel[k]).norm(), 1e-12);
  }
}

TEST(SimulateImu, PutsInTheErrorsItReports) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.sensor.gyro = {0, 0.01, {DriftProcess::Kind::kGaussMarkov, 0.001, 50, 0}, 0.01, 0};
  setup.sensor.accel = {0, 0.05, {}, 0.02, 0};
  setup.accel.bias = Vector3d(0.1, -0.2, 0.3);
  const SimulatedImu truth = simulate_imu(r, perfect(), 1), imu = simulate_imu(r, setup, 1);
  EXPECT_EQ(imu.accel.bias, Vector3d(0.1, -0.2, 0.3));
  for (const std::size_t k : {0u, 3500u, 5999u}) {
    const Vector3d w = truth.recording.gyro[k], f = truth.recording.accel[k];
    const Vector3d gyro = w + imu.gyro.scale.cwiseProduct(w) + imu.gyro.bias + imu.gyro_drift[k];
    const Vector3d accel = f + imu.accel.scale.cwiseProduct(f) + imu.accel.bias;
    EXPECT_LT((imu.recording.gyro[k] - gyro).norm(), 1e-14);
    EXPECT_LT((imu.recording.accel[k] - accel).norm(), 1e-13);
  }
  EXPECT_EQ(imu.gyro_drift.back(), imu.gyro.drift_last);
}

// Gyroscopes have six cross-axis errors and nine of g-sensitivity; accelerometers, which define the axes, three.
TEST(SimulateImu, CrossAxisErrorsAreThoseOfTheSensorUnlessTheyAreGiven) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.sensor.gyro.cross_axis = 0.004;
  setup.sensor.accel.cross_axis = 0.002;
  setup.sensor.gyro_g_sensitivity = 3e-4;
  const SimulatedImu truth = simulate_imu(r, perfect(), 3), imu = simulate_imu(r, setup, 3);
  const Matrix3d &gyro = imu.gyro.misalignment, &accel = imu.accel.misalignment;
  for (const std::size_t k : {0u, 3500u, 5999u}) {
    const Vector3d w = truth.recording.gyro[k], f = truth.recording.accel[k];
    EXPECT_LT((imu.recording.gyro[k] - gyro * w - imu.g_sensitivity * f).norm(), 1e-14);
    EXPECT_LT((imu.recording.accel[k] - accel * f).norm(), 1e-13);
  }
  EXPECT_EQ(gyro.diagonal(), Vector3d::Ones().eval());
  EXPECT_EQ(accel.diagonal(), Vector3d::Ones().eval());
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_NE(imu.g_sensitivity(i, j), 0);
      EXPECT_NE(gyro(i, j), 0);
      EXPECT_EQ(accel(i, j) != 0, j <= i);
    }
  }
  setup.gyro.misalignment = setup.accel.misalignment = 0;
  const SimulatedImu square = simulate_imu(r, setup, 3);
  EXPECT_EQ(square.gyro.misalignment, Matrix3d::Identity().eval());
  EXPECT_EQ(square.accel.misalignment, Matrix3d::Identity().eval());
}

TEST(SimulateImu, SpreadIsDrawnAboutWhatIsGiven) {
  const Truth r = plate(1, 12);
  ImuSetup setup = perfect();
  setup.rate = 0.5;
  setup.sampling = ImuSetup::Sampling::kInstant;
  setup.sensor.gyro.bias = setup.sensor.accel.scale = 100;  // are of no account where a value is given
  setup.gyro.bias = Vector3d(1, 2, 3);
  setup.gyro.bias_spread = Vector3d(0.1, 0, 0.3);
  setup.accel.scale = Vector3d(-0.02, 0.01, 0);
  setup.accel.scale_spread = Vector3d(0.004, 0.005, 0.006);
  constexpr int kSeeds = 2000;
  Vector3d gyro = Vector3d::Zero(), gyro_squares = gyro, accel = gyro, accel_squares = gyro, products = gyro;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const SimulatedImu imu = simulate_imu(r, setup, seed);
    const Vector3d g = imu.gyro.bias - *setup.gyro.bias, a = imu.accel.scale - *setup.accel.scale;
    gyro += g / kSeeds;
    accel += a / kSeeds;
    gyro_squares += g.cwiseAbs2();
    accel_squares += a.cwiseAbs2();
    products += g.cwiseProduct(a) / kSeeds;
  }
  EXPECT_EQ(gyro_squares(1), 0);
  for (const int i : {0, 2}) {
    EXPECT_LT(std::abs(gyro(i)), 3.3 * setup.gyro.bias_spread(i) / std::sqrt(kSeeds));
    expect_variance(gyro_squares(i), setup.gyro.bias_spread(i), kSeeds);
    EXPECT_LT(std::abs(products(i)), 3.3 * setup.gyro.bias_spread(i) * setup.accel.scale_spread(i) / std::sqrt(kSeeds));
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(accel(i)), 3.3 * setup.accel.scale_spread(i) / std::sqrt(kSeeds));
    expect_variance(accel_squares(i), setup.accel.scale_spread(i), kSeeds);
  }
}

TEST(SimulateImu, SpreadMovesTheRowsByItselfAlone) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.sensor.accel = {0.002, 0.05, {DriftProcess::Kind::kGaussMarkov, 0.01, 50, 0}, 0.02, 0};
  setup.accel.bias = Vector3d(0.1, -0.2, 0.3);
  const SimulatedImu without = simulate_imu(r, setup, 4);
  setup.accel.bias_spread = Vector3d(0.01, 0.02, 0.03);
  const SimulatedImu with = simulate_imu(r, setup, 4);
  const Vector3d moved = with.accel.bias - without.accel.bias;
  EXPECT_GT(moved.norm(), 0.005);
  EXPECT_EQ(with.accel.scale, without.accel.scale);
  EXPECT_EQ(with.recording.gyro, without.recording.gyro);
  for (std::size_t k = 0; k < with.recording.accel.size(); k += 50) {
    EXPECT_LT((with.recording.accel[k] - without.recording.accel[k] - moved).norm(), 1e-13);
  }
}

TEST(SimulateImu, PhasesHaveTheMeansOfTheirRows) {
  const Truth r = plate();  // 30 s, 20 s, 10 s
  ImuSetup setup = perfect();
  setup.rate = 19.99;  // no row ends with a phase
  setup.sensor.gyro.drift = {DriftProcess::Kind::kGaussMarkov, 0.01, 50, 0};
  setup.gyro.warm_up = Vector3d(0.1, 0, -0.1);
  setup.gyro.warm_up_time = 25;
  const SimulatedImu imu = simulate_imu(r, setup, 6);
  struct Expected {
    const PhaseDraw& phase;
    double start, end;
  };
  for (const Expected& expected :
       {Expected{imu.gyro.before, 0, 30}, {imu.gyro.run, 30, 50}, {imu.gyro.after, 50, 60}}) {
    Vector3d drift = Vector3d::Zero(), mean = drift, squares = drift;
    std::size_t rows = 0;
    for (std::size_t k = 0; k < imu.signal.size(); ++k) {
      const double t = imu.gps_time[k] - r.start_time();
      if (t < expected.start || t > expected.end) continue;
      drift += imu.gyro_drift[k] + std::exp(-t / 25) * setup.gyro.warm_up;
      mean += imu.signal[k].gyro;
      squares += imu.signal[k].gyro.cwiseAbs2();
      ++rows;
    }
    const auto count = static_cast<double>(rows);
    EXPECT_EQ(expected.phase.rows, rows);
    EXPECT_LT((expected.phase.drift - drift / count).norm(), 1e-13);
    EXPECT_LT((expected.phase.mean - mean / count).norm(), 1e-13);
    EXPECT_LT((expected.phase.rms - (squares / count).cwiseSqrt()).norm(), 1e-13);
  }
  EXPECT_EQ(imu.gyro.before.rows + imu.gyro.run.rows + imu.gyro.after.rows, imu.signal.size());
  EXPECT_EQ(simulate_imu(plate(0), setup, 6).gyro.before.rows, 0U);
}

TEST(SimulateImu, NoiseHasItsDensity) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.sensor.gyro.noise = 8.7e-4;
  setup.sensor.accel.noise = 2e-3;
  const SimulatedImu truth = simulate_imu(r, perfect(), 1), imu = simulate_imu(r, setup, 1);
  const std::size_t rows = imu.recording.time.size();
  double gyro = 0, accel = 0;
  for (std::size_t k = 0; k < rows; ++k) {
    gyro += (imu.recording.gyro[k] - truth.recording.gyro[k]).squaredNorm();
    accel += (imu.recording.accel[k] - truth.recording.accel[k]).squaredNorm();
  }
  expect_variance(gyro, 8.7e-3, 3.0 * static_cast<double>(rows));
  expect_variance(accel, 2e-2, 3.0 * static_cast<double>(rows));
}

TEST(SimulateImu, QuantizationCancelsInTheSum) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.accel.quantization = 5e-4;
  const SimulatedImu truth = simulate_imu(r, perfect(), 1), imu = simulate_imu(r, setup, 1);
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (std::size_t k = 0; k < imu.recording.time.size(); ++k) {
    const Vector3d error = imu.recording.accel[k] - truth.recording.accel[k];
    sum += 0.01 * error;
    squares += error.cwiseAbs2() / static_cast<double>(imu.recording.time.size());
  }
  EXPECT_LT(sum.cwiseAbs().maxCoeff(), 5 * 5e-4);
  EXPECT_NEAR(std::sqrt(squares.mean()), std::sqrt(2.0) * 5e-4 / 0.01, 2e-3);
}

TEST(SimulateImu, HoldsAndCountsWhatIsBeyondTheRange) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.sensor.accel.range = 9.9;
  const SimulatedImu imu = simulate_imu(r, setup, 1);
  std::size_t clipped = 0;
  for (const Vector3d& f : imu.recording.accel) {
    EXPECT_LE(f.cwiseAbs().maxCoeff(), 9.9);
    clipped += f.cwiseAbs().maxCoeff() == 9.9 ? 1 : 0;
  }
  EXPECT_GT(clipped, 50u);
  EXPECT_EQ(clipped, imu.accel.clipped);
  EXPECT_EQ(imu.gyro.clipped, 0u);
}

TEST(SimulateImu, ClockFollowsItsEquation) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.clock_offset = -3.7;
  setup.clock_drift = 50e-6;
  const SimulatedImu imu = simulate_imu(r, setup, 1);
  const Truth b = r.attached(setup.q_rb, setup.p_rb_r);
  const double first = imu.recording.time.front();
  for (const std::size_t k : {0u, 4000u, 5999u}) {
    const double t = imu.recording.time[k];
    EXPECT_NEAR(imu.gps_time[k], t + 3.7 - 50e-6 * (t - first), 1e-9);
    EXPECT_LT((imu.recording.gyro[k] - b.mean(imu.gps_time[k] - 0.01 * (1 - 50e-6), imu.gps_time[k]).gyro).norm(),
              1e-7);
  }
}

TEST(SimulateImu, SameSeedSameBytesWhateverElseThereIs) {
  const Truth r = plate();
  ImuSetup setup = perfect();
  setup.sensor.gyro = {.noise = 8.7e-4,
                       .bias = 0.01,
                       .drift = {DriftProcess::Kind::kGaussMarkov, 0.001, 50, 0},
                       .scale = 0.01,
                       .range = 5};
  const SimulatedImu a = simulate_imu(r, setup, 11), b = simulate_imu(r, setup, 11), c = simulate_imu(r, setup, 12);
  ImuSetup with_accel = setup;
  with_accel.sensor.accel.noise = 0.002;
  const SimulatedImu d = simulate_imu(r, with_accel, 11);
  EXPECT_EQ(a.recording.gyro, b.recording.gyro);
  EXPECT_EQ(a.recording.gyro, d.recording.gyro);
  EXPECT_NE(a.recording.gyro, c.recording.gyro);
}

TEST(SimulateGnss, ErrorsAreWhatTheSigmasSay) {
  const Truth r = plate(600, 20);
  GnssSetup setup;
  setup.name = "gnss";
  setup.p_ra_r = {0.1, -0.2, -0.5};
  setup.position_drift = GaussMarkov{{0.4, 0.4, 0.7}, 0.5};
  setup.position_noise = {0.3, 0.3, 0.5};
  setup.velocity_noise.setConstant(0.05);
  const GnssRecording fixes = simulate_gnss(r, setup, 4);
  const Truth antenna = r.attached(Quaterniond::Identity(), setup.p_ra_r);
  ASSERT_EQ(fixes.fixes.size(), 6301u);
  double velocity = 0, position = 0;
  for (const GeodeticFix& fix : fixes.fixes) {
    const TruthState s = antenna.at(fix.time);
    const Matrix3d R_nw = r.world().rotation_wn(s.p_wb).transpose();
    const Vector3d error = R_nw * (r.world().from_geodetic(fix.position) - s.p_wb);
    position += error.cwiseQuotient(fix.sigma_position).squaredNorm();
    ASSERT_TRUE(fix.velocity);
    velocity += (fix.velocity->value - R_nw * s.v_wb).squaredNorm();
  }
  EXPECT_NEAR(fixes.fixes.front().sigma_position.x(), 0.5, 1e-12);
  expect_variance(velocity, 0.05, 3 * 6301);
  // A Gauss-Markov part of 16 in 25 of the variance, over 630 s, is worth one draw in its correlation time of 0.5 s.
  const Band band = chi_squared_band(0.999, 3, 630 / 0.5);
  EXPECT_TRUE(band.contains(position / (3 * 6301))) << position / (3 * 6301);
}

TEST(SimulateGnss, DelayStampsThePastWithNow) {
  const Truth r = plate();
  GnssSetup setup;
  setup.name = "gnss";
  setup.position_noise.setZero();
  setup.velocity_noise.setZero();
  setup.delay = 0.1;
  const GnssRecording fixes = simulate_gnss(r, setup, 4);
  const GeodeticFix& fix = fixes.fixes[400];
  EXPECT_FALSE(fix.velocity);
  EXPECT_LT((r.world().from_geodetic(fix.position) - r.at(fix.time - 0.1).p_wb).norm(), 1e-6);
}

TEST(SimulateGnss, VelocitiesMayBeLateByThemselves) {
  const Truth r = plate();
  GnssSetup setup;
  setup.name = "gnss";
  setup.position_noise.setZero();
  setup.velocity_noise.setConstant(1e-9);
  setup.velocity_delay = 0.3;
  const GeodeticFix fix = simulate_gnss(r, setup, 4).fixes[400];
  EXPECT_LT((r.world().from_geodetic(fix.position) - r.at(fix.time).p_wb).norm(), 1e-6);
  const TruthState then = r.at(fix.time - 0.3);
  EXPECT_LT((r.world().rotation_wn(then.p_wb) * fix.velocity->value - then.v_wb).norm(), 1e-6);
  EXPECT_GT((then.v_wb - r.at(fix.time).v_wb).norm(), 0.01) << "which the time matters for";
}

TEST(SimulateAttitude, DelayStampsThePastWithNow) {
  const Truth r = plate();
  AttitudeSetup setup;
  setup.name = "attitude";
  setup.noise.setConstant(1e-9);
  setup.delay = 0.05;
  const EulerFix fix = simulate_attitude(r, setup, 4).fixes[400];
  const auto angles = [&](double t) {
    const TruthState s = r.at(t);
    return to_euler(Quaterniond(r.world().rotation_wn(s.p_wb).transpose()) * s.q_wb);
  };
  EXPECT_LT((fix.angles - angles(fix.time - 0.05)).norm(), 1e-6);
  EXPECT_GT((fix.angles - angles(fix.time)).norm(), 1e-4);
}

TEST(SimulateAttitude, IsThePlateInLocalAxesWithinItsSigmas) {
  const Truth r = plate(100, 20).attached(from_euler({0.02, -0.73, 0.01}), Vector3d::Zero());
  AttitudeSetup setup;
  setup.name = "attitude";
  setup.noise.setConstant(0.001);
  setup.drift = GaussMarkov{{0.002, 0.002, 0.004}, 0.1};
  const AttitudeRecording fixes = simulate_attitude(r, setup, 9);
  Vector3d squares = Vector3d::Zero();
  for (const EulerFix& fix : fixes.fixes) {
    const TruthState s = r.at(fix.time);
    const Quaterniond q_nr = Quaterniond(r.world().rotation_wn(s.p_wb).transpose()) * s.q_wb;
    Vector3d error = fix.angles - to_euler(q_nr);
    for (double& angle : error) angle = std::remainder(angle, 2 * std::numbers::pi);
    squares += error.cwiseQuotient(fix.sigma).cwiseAbs2();
  }
  const Vector3d mean = squares / static_cast<double>(fixes.fixes.size());
  // Mostly Gauss-Markov, of 0.1 s: one draw in that time or in the 0.1 s between fixes.
  const Band band = chi_squared_band(0.999, 1, 0.5 * static_cast<double>(fixes.fixes.size()));
  for (const double square : mean) EXPECT_TRUE(band.contains(square)) << mean.transpose();
}

}  // namespace
}  // namespace piste
