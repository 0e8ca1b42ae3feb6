// Measurement Jacobians of every model, for every block, at random states.

#include <gtest/gtest.h>

#include <limits>

#include "piste/model/measurement_list.h"
#include "piste/model/strapdown.h"
#include "support/jacobian_check.h"
#include "support/random.h"
#include "support/synthetic_log.h"

namespace piste {
namespace {

using test::check_jacobians;
using test::Random;

constexpr int kStates = 20;
const World kWorld({0.81, 0.13, 800});

// A raw step of wild motion; the models take it corrected, so that biases and scales act through it.
ImuStep raw_step(Random& random) {
  return {0.01, random.vector(0.03), random.vector(0.2), random.vector(5), random.vector(50)};
}

BodyMotion motion_of(const ImuStep& raw, const Estimate& x) {
  const ImuStep step = correct(raw, x);
  return {.rate = step.mean_rate(), .force = step.mean_force()};
}

// Means that are not the motion of the moment.
RecentMotion recent_motion(Random& random) {
  return {.rate = random.vector(2), .force = random.vector(15), .force_change = random.vector(50)};
}

AntennaMotion antenna_motion(const ImuStep& raw, const RecentMotion& recent, const Estimate& x) {
  const ImuStep mean = correct({1, recent.rate, recent.force, Vector3d::Zero(), Vector3d::Zero()}, x);
  const BodyMotion now = motion_of(raw, x);
  return {now, now.rate, 0, {.rate = mean.dtheta, .force = mean.dvel}, recent.force_change};
}

// Gravity near the body, and a local level that is turned as it is some hundred kilometres from the origin.
Gravity gravity_near(const Estimate& x, Random& random) {
  Gravity g = kWorld.gravity(x.p_wb + random.vector(20));
  g.R_wn = so3_exp(random.vector(0.1)).toRotationMatrix();
  return g;
}

GnssFix fix_near(const Estimate& x, Random& random) {
  return {0,
          x.p_wb + random.vector(2),
          {0.5, 0.6, 0.9},
          FixVelocity{x.v_wb + random.vector(), {0.1, 0.2, 0.3}},
          {0.4, -0.2, 0.3},
          {0.8, 1, 1.3}};
}

TEST(Jacobians, GnssPosition) {
  Random random(1);
  for (int i = 0; i < kStates; ++i) {
    const Estimate x = random.estimate();
    const ImuStep raw = raw_step(random);
    const GnssFix fix = fix_near(x, random);
    const Gravity gravity = gravity_near(x, random);
    const RecentMotion recent = recent_motion(random);
    const PositionDrift metres = GaussMarkov{{0.4, 0.4, 0.7}, 60}, share = PositionDrift::of_share({0.7, 0.6, 0.9}, 60);
    for (const auto& drift : {std::optional<PositionDrift>(), std::optional(metres), std::optional(share)}) {
      for (int receiver = 0; receiver < (drift ? kDriftingReceivers : 1); ++receiver) {
        check_jacobians(
            [&](const Estimate& y) {
              return linearize_position(fix, drift, y, antenna_motion(raw, recent, y), kWorld.earth_rate(), gravity,
                                        {y.gnss_delay, Block::kGnssDelay}, false, receiver);
            },
            x);
      }
    }
  }
}

// The state of a slow error that is a share of what is stated is in units of that: a fix of three times the sigma shows
// three times the error, and its white part is the same share of it.
TEST(Jacobians, AShareFollowsTheStatedSigma) {
  Random random(4);
  const Estimate x = random.estimate();
  const ImuStep raw = raw_step(random);
  const Gravity gravity = gravity_near(x, random);
  GnssFix fix = fix_near(x, random);
  fix.correlation.setZero();
  fix.slow_level.setOnes();
  const auto drift = PositionDrift::of_share({0.6, 0.6, 0.8}, 60);
  const auto seen = [&] {
    return linearize_position(fix, drift, x, {motion_of(raw, x)}, kWorld.earth_rate(), gravity, {}, false, 2);
  };
  const auto white = [&](const Linearization& lin) {
    return (gravity.R_wn.transpose() * lin.covariance * gravity.R_wn).diagonal().cwiseSqrt().eval();
  };
  const Linearization before = seen();
  EXPECT_TRUE(white(before).isApprox(Vector3d(0.8, 0.8, 0.6).cwiseProduct(fix.sigma_position), 1e-9));
  const Vector3d slow = slow_error(fix, drift, 2, x);
  fix.sigma_position *= 3;
  const Linearization after = seen();
  EXPECT_TRUE(white(after).isApprox(3 * white(before), 1e-9));
  EXPECT_TRUE((before.residual - after.residual).isApprox(2 * (gravity.R_wn * slow), 1e-9));
}

// White and slow part make up the covariance that is stated, correlations and all.
TEST(Jacobians, AShareLeavesTheTotal) {
  Random random(5);
  const Estimate x = random.estimate();
  const ImuStep raw = raw_step(random);
  const Gravity gravity = gravity_near(x, random);
  GnssFix fix = fix_near(x, random);
  fix.slow_level.setOnes();
  const auto drift = PositionDrift::of_share({0.6, 0.7, 0.9}, 60);
  const Linearization lin =
      linearize_position(fix, drift, x, {motion_of(raw, x)}, kWorld.earth_rate(), gravity, {}, false, 1);
  const Matrix3d J = lin.jacobian(position_drift_block(1, true));
  const Matrix3d total = lin.covariance + J * drift.sigma.cwiseAbs2().asDiagonal() * J.transpose();
  const Matrix3d L = gravity.R_wn * fix.position_factor();
  EXPECT_TRUE(total.isApprox(L * L.transpose(), 1e-12));
}

// With a limit of the white part, fixes that state more are slow for the rest: the total stays what is stated.
TEST(Jacobians, ALimitOfTheWhitePartMakesTheRestSlow) {
  auto drift = PositionDrift::of_share({0.6, 0.6, 0.6}, 60);
  drift.most_white = 0.02;
  Random random(7);
  const Estimate x = random.estimate();
  const ImuStep raw = raw_step(random);
  const Gravity gravity = gravity_near(x, random);
  GnssFix fix = fix_near(x, random);
  fix.correlation.setZero();
  fix.slow_level.setOnes();
  for (const double stated : {0.01, 0.025, 0.026, 0.5}) {
    fix.sigma_position.setConstant(stated);
    const auto seen = [&](const Estimate& y) {
      return linearize_position(fix, drift, y, {motion_of(raw, y)}, kWorld.earth_rate(), gravity);
    };
    const Linearization lin = seen(x);
    const Matrix3d slow = lin.jacobian(position_drift_block(0, true));
    const double white = std::min(0.8 * stated, 0.02);
    EXPECT_TRUE(lin.covariance.isApprox(white * white * Matrix3d::Identity(), 1e-9)) << stated;
    EXPECT_TRUE(
        (lin.covariance + 0.36 * slow * slow.transpose()).isApprox(stated * stated * Matrix3d::Identity(), 1e-9))
        << stated;
    check_jacobians(seen, x);
  }
}

// A receiver that states three times as much as it did: the slow part is still small, and the white one makes up the
// total. One that states a third: the slow part is still large, and the white one as large a share as ever.
TEST(Jacobians, TheSlowPartFollowsWhatIsStated) {
  const auto drift = PositionDrift::of_share({0.8, 0.8, 0.8}, 60);
  Random random(6);
  const Estimate x = random.estimate();
  const ImuStep raw = raw_step(random);
  const Gravity gravity = gravity_near(x, random);
  GnssFix fix = fix_near(x, random);
  fix.correlation.setZero();
  const auto variances = [&](double level) {
    fix.slow_level.setConstant(level);
    const Linearization lin = linearize_position(fix, drift, x, {motion_of(raw, x)}, kWorld.earth_rate(), gravity);
    const Matrix3d slow = 0.8 * gravity.R_wn.transpose() * lin.jacobian(position_drift_block(0, true));
    const Matrix3d white = gravity.R_wn.transpose() * lin.covariance * gravity.R_wn;
    const Vector3d stated = fix.sigma_position.cwiseAbs2();
    return std::pair((slow * slow.transpose()).diagonal().cwiseQuotient(stated).mean(),
                     white.diagonal().cwiseQuotient(stated).mean());
  };
  const auto [small, rest] = variances(1.0 / 3);
  EXPECT_NEAR(small, 0.64 / 9, 1e-9);
  EXPECT_NEAR(small + rest, 1, 1e-9);
  const auto [large, least] = variances(3);
  EXPECT_NEAR(large, 0.64 * 9, 1e-9);
  EXPECT_NEAR(least, 0.36, 1e-9);
}

TEST(Jacobians, GnssVelocity) {
  Random random(2);
  for (int i = 0; i < kStates; ++i) {
    const Estimate x = random.estimate();
    const ImuStep raw = raw_step(random);
    const GnssFix fix = fix_near(x, random);
    const Gravity gravity = gravity_near(x, random);
    const RecentMotion recent = recent_motion(random);
    check_jacobians(
        [&](const Estimate& y) {
          return linearize_velocity(fix, y, antenna_motion(raw, recent, y), kWorld.earth_rate(), gravity, false,
                                    {y.velocity_delay, Block::kVelocityDelay});
        },
        x);
  }
}

TEST(Jacobians, GnssVelocityThatIsAMean) {
  Random random(23);
  for (int i = 0; i < kStates; ++i) {
    const Estimate x = random.estimate();
    const ImuStep raw = raw_step(random);
    const GnssFix fix = fix_near(x, random);
    const Gravity gravity = gravity_near(x, random);
    const RecentMotion recent = recent_motion(random), before = recent_motion(random);
    check_jacobians(
        [&](const Estimate& y) {
          return linearize_mean_velocity(fix, 0.4, y, antenna_motion(raw, recent, y), antenna_motion(raw, before, y),
                                         kWorld.earth_rate(), gravity, false,
                                         {y.velocity_delay, Block::kVelocityDelay});
        },
        x);
  }
}

TEST(Jacobians, GnssVelocityOfABodyThatStandsStill) {
  Random random(3);
  for (int i = 0; i < kStates; ++i) {
    Estimate x = random.estimate();
    x.v_wb.setZero();
    x.gyro_g_sensitivity.setZero();
    ImuStep raw = raw_step(random);
    raw.dtheta = raw.dt * (x.gyro_bias + x.gyro_drift);
    const GnssFix fix = fix_near(x, random);
    const Gravity gravity = kWorld.gravity(x.p_wb);
    check_jacobians(
        [&](const Estimate& y) {
          return linearize_velocity(fix, y, {motion_of(raw, y)}, kWorld.earth_rate(), gravity, true);
        },
        x);
  }
}

// The gyro's noise turns the lever arm: what it adds is what differences of the measured rate say.
TEST(Jacobians, NoiseOfTheRateInGnssVelocity) {
  Random random(6);
  const Gravity gravity = kWorld.gravity(Vector3d::Zero());
  for (int i = 0; i < kStates; ++i) {
    Estimate x = random.estimate();
    x.gyro_scale.setZero();  // noise is of the corrected rate
    const ImuStep raw = raw_step(random);
    const GnssFix fix = fix_near(x, random);
    const auto measured = [&](const Vector3d& error) {
      BodyMotion motion = motion_of(raw, x);
      motion.rate += error;
      motion.rate_variance = Vector3d(1, 4, 9);
      return linearize_velocity(fix, x, {motion}, kWorld.earth_rate(), gravity, false);
    };
    Matrix3d J;
    for (int k = 0; k < 3; ++k) J.col(k) = measured(Vector3d::Unit(k)).residual - measured(Vector3d::Zero()).residual;
    const Matrix3d white = fix.velocity->sigma.cwiseAbs2().asDiagonal();
    const Matrix3d expected = white + J * Vector3d(1, 4, 9).asDiagonal() * J.transpose();
    EXPECT_LT((measured(Vector3d::Zero()).covariance - expected).norm(), 1e-9 * expected.norm());
  }
}

// Where down was not measured, the two rows are north and east of the local level, as they would be beside it.
TEST(Jacobians, GnssVelocityWithoutDown) {
  Random random(7);
  const Estimate x = random.estimate();
  const ImuStep raw = raw_step(random);
  const Gravity gravity = gravity_near(x, random);
  GnssFix fix = fix_near(x, random);
  const auto linearized = [&] {
    return linearize_velocity(fix, x, {motion_of(raw, x)}, kWorld.earth_rate(), gravity, false);
  };
  Linearization all = linearized();
  all.turn(gravity.R_wn.transpose());
  // What is not measured has no influence, whatever stands in its place.
  fix.velocity->value += 7 * gravity.R_wn.col(2);
  fix.velocity->sigma.z() = std::numeric_limits<double>::infinity();
  const Linearization two = linearized();
  EXPECT_EQ(all.rows, 3);
  EXPECT_EQ(two.rows, 2);
  EXPECT_LT((two.residual - all.residual).head<2>().norm(), 1e-12);
  EXPECT_EQ(two.covariance, two.covariance);  // no NaN
  EXPECT_LT((two.covariance - all.covariance).topLeftCorner(2, 2).norm(), 1e-14);
  ASSERT_EQ(two.count(), all.count());
  for (int i = 0; i < two.count(); ++i) EXPECT_EQ(two.term(i).jacobian, all.term(i).jacobian);
}

TEST(Jacobians, Attitude) {
  Random random(4);
  for (int i = 0; i < kStates; ++i) {
    const Estimate x = random.estimate();
    const Quaterniond expected = so3_exp(x.attitude_drift) * x.q_wb * (so3_exp(x.boresight_drift) * x.q_rb).conjugate();
    const Vector3d residual = 0.5 * random.uniform() * random.vector().normalized();
    const AttitudeFix fix{0, so3_exp(residual) * expected, 1e-6 * random.covariance(3)};
    const ImuStep raw = raw_step(random);
    const RecentMotion recent = recent_motion(random);
    const Matrix3d R_wn = random.rotation().toRotationMatrix();
    for (const bool coloured : {false, true}) {
      check_jacobians(
          [&](const Estimate& y) {
            const Vector3d white = coloured ? Vector3d(0.1, 0.2, 0.3) : Vector3d::Ones();
            const Turning turning{.earth_rate = Vector3d(0.03, 0.02, -0.04),  // faster, to stand out of rounding
                                  .rate = antenna_motion(raw, recent, y).mean.rate,
                                  .lag = {y.attitude_delay, Block::kAttitudeDelay},
                                  .force = antenna_motion(raw, recent, y).mean.force};
            return linearize_attitude(fix, white, y, R_wn, nullptr, turning);
          },
          x);
    }
  }
}

// An error that no fix can tell, of attitude and boresight together, is told by none after one has been used either: of
// second order in its correction, where the Jacobians at the estimate leave one of first order.
TEST(Jacobians, AttitudeLeavesUnknownWhatItCannotTell) {
  Random random(9);
  for (int i = 0; i < kStates; ++i) {
    const Estimate x = random.estimate();
    const Matrix3d R_wn = random.rotation().toRotationMatrix();
    const Vector3d alpha = random.vector(), direction = random.vector().normalized();
    const auto seen = [&](double size, bool half_way) {
      FullError correction = FullError::Zero();
      correction.segment<3>(full_offset(Block::kAttitude)) = size * direction;
      const Estimate after = boxplus(x, correction);
      const Quaterniond q_wr =
          so3_exp(R_wn * after.attitude_drift) * after.q_wb * (so3_exp(after.boresight_drift) * after.q_rb).conjugate();
      const AttitudeFix fix{0, q_wr, 1e-6 * Matrix3d::Identity()};
      const Linearization before = linearize_attitude(fix, Vector3d::Ones(), x, R_wn, half_way ? &after : nullptr);
      const Vector3d beta = -before.term(1).jacobian.lu().solve(before.term(0).jacobian * alpha);
      const Linearization next = linearize_attitude(fix, Vector3d::Ones(), after, R_wn);
      const Vector3d turned = so3_left_jacobian(size * direction) * alpha;  // by the reset
      return (next.term(0).jacobian * turned + next.term(1).jacobian * beta).norm() / alpha.norm();
    };
    EXPECT_LT(seen(1e-3, true), 1e-6);
    EXPECT_GT(seen(1e-3, false), 1e-5 * alpha.cross(direction).norm() / alpha.norm());
  }
}

TEST(Jacobians, ZeroVelocity) {
  Random random(5);
  for (int i = 0; i < kStates; ++i) {
    Estimate x = random.estimate();
    x.v_wb.setZero();  // where it is linearised, by design
    check_jacobians([](const Estimate& y) { return linearize_zero_velocity({}, y); }, x);
  }
}

TEST(Jacobians, ZeroRate) {
  Random random(6);
  for (int i = 0; i < kStates; ++i) {
    const Vector3d mean_gyro = random.vector(0.01);
    // A faster Earth, so that its terms stand out of the differences' rounding.
    const Vector3d earth_rate = random.vector(0.1), gravity = random.vector(10);
    check_jacobians(
        [&](const Estimate& y) { return linearize_zero_rate({}, mean_gyro, 0.5, 1e-3, y, earth_rate, gravity); },
        random.estimate());
  }
}

TEST(Jacobians, Magnetometer) {
  Random random(7);
  for (int i = 0; i < kStates; ++i) {
    const Estimate x = random.estimate();
    const Matrix3d R_wn = random.rotation().toRotationMatrix();
    const MagneticSample sample{0, random.vector(40), Vector3d(20, 5, 40) + random.vector(3)};
    check_jacobians([&](const Estimate& y) { return linearize_magnetic_field(sample, 0.5, y, R_wn); }, x);
  }
}

// With two antennas at any lean, and with a local level that is turned. Upright they have no azimuth.
TEST(Jacobians, HeadingAndPitchOfABaseline) {
  Random random(8);
  for (int i = 0; i < kStates; ++i) {
    const Estimate x = random.estimate();
    const Matrix3d R_wn = random.rotation().toRotationMatrix();
    const Vector3d baseline = random.vector(2);
    HeadingFix fix{0, random.uniform(), 0.01, 0.1, 0.02};
    const Vector3d along_n = R_wn.transpose() * (x.q_wb * baseline.normalized());
    if (along_n.head<2>().norm() < 0.18) {
      EXPECT_EQ(linearize_heading(fix, baseline, x, R_wn).has_value(), along_n.head<2>().norm() >= 0.17);
      continue;
    }
    check_jacobians([&](const Estimate& y) { return linearize_heading(fix, baseline, y, R_wn).value(); }, x);
    EXPECT_EQ(linearize_heading(fix, baseline, x, R_wn).value().rows, 2);
    fix.pitch.reset();
    EXPECT_EQ(linearize_heading(fix, baseline, x, R_wn).value().rows, 1);
    const Vector3d upright = x.q_wb.conjugate() * (R_wn * Vector3d(0.1, 0, 1));
    EXPECT_FALSE(linearize_heading(fix, upright, x, R_wn).has_value());
  }
}

// A fix of each type of the list, near what the estimate predicts. A new type needs one, or this does not compile.
template <class Fix>
Fix some_fix(const Estimate& x, Random& random);

template <>
GnssFix some_fix(const Estimate& x, Random& random) {
  return fix_near(x, random);
}
template <>
AttitudeFix some_fix(const Estimate& x, Random& random) {
  const Quaterniond q_wr = so3_exp(x.attitude_drift) * x.q_wb * (so3_exp(x.boresight_drift) * x.q_rb).conjugate();
  return {0, so3_exp(0.3 * random.vector().normalized()) * q_wr, 1e-6 * random.covariance(3)};
}
template <>
MagneticSample some_fix(const Estimate& x, Random& random) {
  const Vector3d earth = Vector3d(20, 5, 40) + random.vector(3);
  return {0, x.q_wb.conjugate() * earth, earth};
}
template <>
RestFix some_fix(const Estimate&, Random& random) {
  return {0, 0.5, random.vector(0.01)};
}

template <>
VehicleFix some_fix(const Estimate&, Random&) {
  return {};
}
template <>
SpeedFix some_fix(const Estimate&, Random& random) {
  return {0, random.gaussian(10), 0.1};
}
template <>
HeightFix some_fix(const Estimate& x, Random& random) {
  return {0, -x.p_wb.z() + random.uniform(), 0.5};
}
template <>
HeadingFix some_fix(const Estimate&, Random& random) {
  return {0, random.uniform(), 0.01};
}

template <>
ParityFix some_fix(const Estimate&, Random&) {
  Random own(11);  // so that what follows in the test stays as it was
  const Vector3d gyro = own.vector(0.01), accel = own.vector(0.1), rate = own.vector(2), force = own.vector(15);
  return {0, 0.1, Parity{.value = gyro}, Parity{.value = accel}, rate, force};
}

// Three IMUs that differ in everything.
std::vector<ImuSensor> some_units() {
  std::vector<ImuSensor> imus(3);
  double factor = 1;
  for (ImuSensor& unit : imus) {
    for (TriadErrors* triad : {&unit.gyro, &unit.accel}) {
      triad->noise = 1e-3 * factor;
      triad->bias = 0.01 / factor;
      triad->drift = {DriftProcess::Kind::kGaussMarkov, 0.003 * factor * factor, 100, 0};
      triad->scale = 0.02;
      factor *= 1.3;
    }
  }
  return imus;
}

// What the filter calls, channel by channel, with every block estimated, and fixes that belong 60 to 120 ms or, of the
// attitude, 30 ms before the estimate.
TEST(Jacobians, EveryTypeOfTheList) {
  Random random(10);
  FilterOptions options;
  options.sensor.gyro.noise = options.sensor.accel.noise = 1e-3;
  options.gnss.resize(3);
  options.gnss[1].drift = GaussMarkov{{0.4, 0.4, 0.7}, 60};
  options.gnss[2].drift = PositionDrift::of_share({0.7, 0.7, 0.9}, 60);
  options.gnss[2].lever_arm_sway = GaussMarkov{Vector3d::Constant(0.03), 0.5};
  options.attitude.resize(1);
  options.magnetometer.emplace();
  options.vehicle.emplace();
  options.odometer.emplace();
  options.barometer.emplace();
  options.heading.emplace();
  options.imus = some_units();
  options.unit_axes = {Matrix3d::Identity(), so3_exp(Vector3d(0.1, -0.7, 0.3)).toRotationMatrix(),
                       so3_exp(Vector3d(-0.05, 0.02, 1.5)).toRotationMatrix()};
  const Vector3d earth_rate(0.03, 0.02, -0.04);  // a faster Earth, so that its terms stand out of rounding
  std::vector<Block> blocks;
  for (const BlockInfo& row : kBlocks) blocks.push_back(row.block);
  const StateLayout layout(blocks);
  int checked = 0;
  for (int i = 0; i < kStates; ++i) {
    Estimate x = random.estimate();
    const Gravity gravity = gravity_near(x, random);
    const ImuStep raw = raw_step(random);
    const RecentMotion recent = recent_motion(random);
    MeasurementList::for_each([&]<class Type>() {
      using Fix = typename Type::Fix;
      const bool rest = std::is_same_v<Type, ZeroUpdates>;
      Estimate at = x;
      if (rest) at.v_wb.setZero();  // where it is linearised, by design
      for (int sensor = 0; sensor < Type::sensors(options); ++sensor) {
        const Fix fix = some_fix<Fix>(at, random);
        const double into = 0.3 * raw.dt;  // where the instrument has the same rate
        const MeasurementContext context{.options = options,
                                         .layout = layout,
                                         .earth_rate = earth_rate,
                                         .gravity = gravity,
                                         .step = raw,
                                         .into_step = into,
                                         .rate_variance = Vector3d::Zero(),
                                         .still = rest,
                                         .elapsed = 1,
                                         .moved = 0.01,
                                         .recent = recent,
                                         .neighbour_rate = raw.mean_rate() + (into - 0.5 * raw.dt) * raw.rate_slope};
        for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
          const auto model = [&](const Estimate& y) {
            return Type::linearize(fix, sensor, channel, context, y).value();
          };
          SCOPED_TRACE(Type::kName);
          if (!Type::linearize(fix, sensor, channel, context, at)) continue;  // a baseline that is upright by chance
          check_jacobians(model, at);
          ++checked;
        }
      }
    });
  }
  EXPECT_GE(checked, kStates * 17);
}

}  // namespace
}  // namespace piste
