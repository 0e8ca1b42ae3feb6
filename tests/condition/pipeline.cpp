#include "piste/condition/pipeline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "math/magnetic_field.h"
#include "piste/condition/rest_detection.h"
#include "piste/core/error.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;

const Vector3d kForce(0.5, -0.25, -9.8);

// Rates that vary with the row number; 100 Hz from time 1000 s.
Recording recording(int rows, bool increments = false) {
  Recording r;
  r.imu.file = "imu.csv";
  r.imu.increments = increments;
  const double unit = increments ? 0.01 : 1;
  for (int i = 0; i < rows; ++i) {
    r.imu.time.push_back(1000 + 0.01 * i);
    r.imu.gyro.emplace_back(Vector3d(0.1, 0.2, 0.01 * i) * unit);
    r.imu.accel.emplace_back(kForce * unit);
  }
  r.gnss.push_back({"gnss.csv", {}});
  for (int i = 0; i < rows; i += 10) {
    GeodeticFix fix{.time = 1000 + 0.01 * i,
                    .position = {46 * kDegree, 7 * kDegree + 1e-7 * i, 1600},
                    .sigma_position = {1, 2, 3},
                    .velocity = {}};
    fix.velocity = {Vector3d(3, 4, 0.5), Vector3d(0.1, 0.2, 0.3)};
    r.gnss[0].fixes.push_back(fix);
  }
  return r;
}

void drop_rows(ImuRecording& imu, int first, int count) {
  for (auto* v : {&imu.gyro, &imu.accel}) v->erase(v->begin() + first, v->begin() + first + count);
  imu.time.erase(imu.time.begin() + first, imu.time.begin() + first + count);
}

Vector3d total_rotation(const Log& log) {
  Vector3d sum = Vector3d::Zero();
  for (const ImuSample& s : log.imu) sum += s.dtheta;
  return sum;
}

void expect_contiguous(const Log& log) {
  for (std::size_t i = 1; i < log.imu.size(); ++i) {
    ASSERT_NEAR(log.imu[i].time - log.imu[i].interval, log.imu[i - 1].time, 1e-9) << i;
  }
}

TEST(Condition, MeanRowsBecomeIncrements) {
  const Log log = condition(recording(100), {});
  ASSERT_EQ(log.imu.size(), 100u);
  EXPECT_NEAR(log.imu[0].interval, 0.01, 1e-9);
  EXPECT_LT((log.imu[7].dtheta - Vector3d(0.1, 0.2, 0.07) * 0.01).norm(), 1e-12);
  EXPECT_LT((log.imu[7].dvel - kForce * 0.01).norm(), 1e-10);
  expect_contiguous(log);
}

TEST(Condition, IncrementsPassAsTheyAre) {
  const Recording r = recording(100, true);
  const Log log = condition(r, {});
  EXPECT_EQ(log.imu[7].dtheta, r.imu.gyro[7]);
  EXPECT_EQ(log.imu[7].dvel, r.imu.accel[7]);
}

TEST(Condition, InstantaneousRowsAreIntegrated) {
  ConditioningOptions options;
  options.imu.instantaneous = true;
  const Log log = condition(recording(100), options);
  ASSERT_EQ(log.imu.size(), 99u);
  EXPECT_NEAR(log.imu[6].dtheta.z(), 0.01 * 0.065, 1e-12);  // from row 6 to row 7
  expect_contiguous(log);
}

// The field of the model at the place, as far as nothing else is stated, and samples no closer than asked.
TEST(Condition, MagneticSamplesComeWithTheFieldOfTheEarth) {
  Recording r = recording(100);
  r.imu.magnetic.assign(100, Vector3d(0.5, 0, 0.9));
  ConditioningOptions options;
  options.magnetic = {.year = 2026, .unit = 48, .interval = 0.1};
  const Log log = condition(r, options);
  ASSERT_EQ(log.magnetic.size(), 10U);
  EXPECT_NEAR(log.magnetic[1].time - log.magnetic[0].time, 0.1, 1e-9);
  EXPECT_LT((log.magnetic[0].field - Vector3d(24, 0, 43.2)).norm(), 1e-12);
  const Vector3d model = magnetic_field({46 * kDegree, 7 * kDegree, 1600}, 2026);
  EXPECT_LT((log.magnetic[0].earth - model).norm(), 1e-3);
  options.magnetic.declination = 10 * kDegree;
  const Vector3d turned = condition(r, options).magnetic[0].earth;
  EXPECT_NEAR(std::atan2(turned.y(), turned.x()), 10 * kDegree, 1e-12);
  EXPECT_NEAR(turned.norm(), model.norm(), 1e-3);
  // A hundred kilometres on, the field is the one there.
  for (std::size_t i = 1; i < r.gnss[0].fixes.size(); ++i) r.gnss[0].fixes[i].position.longitude += 1.3 * kDegree;
  options.magnetic.declination.reset();
  const Vector3d far = condition(r, options).magnetic.back().earth;
  EXPECT_LT((far - magnetic_field({46 * kDegree, 8.3 * kDegree, 1600}, 2026)).norm(), 1e-3);
  EXPECT_GT((far - model).norm(), 0.05);
  options.magnetic.field = Vector3d(21, 1, 42);
  EXPECT_EQ(condition(r, options).magnetic.back().earth, Vector3d(21, 1, 42));
}

TEST(Condition, AxesTurnEverything) {
  ConditioningOptions options;
  options.imu.R_bs << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  options.gyro_range = 0.2;
  Recording r = recording(20);
  r.imu.magnetic.assign(20, Vector3d(20, -3, 44));
  const Log log = condition(r, options);
  EXPECT_LT((log.imu[0].dtheta - Vector3d(0.2, -0.1, 0) * 0.01).norm(), 1e-12);
  EXPECT_EQ(log.magnetic[0].field, Vector3d(-3, -20, 44));
  EXPECT_EQ(log.imu[0].clipped_gyro, 1);  // forward, where the sensor's y points
}

TEST(Condition, ClockOffsetAndDrift) {
  ConditioningOptions options;
  options.imu.clock_offset = 0.25;
  options.imu.clock_drift = 1e-3;
  const Log log = condition(recording(100), options);
  EXPECT_NEAR(log.imu[0].time, 999.75, 1e-9);
  EXPECT_NEAR(log.imu[50].time, 1000.5 - 0.25 - 0.5e-3, 1e-9);
  EXPECT_NEAR(log.imu[50].interval, 0.01 * (1 - 1e-3), 1e-9);
}

TEST(Condition, ClippedSamplesAreMarkedAndCounted) {
  ConditioningOptions options;
  options.gyro_range = 0.9;
  options.accel_range = 9.8;
  const Log log = condition(recording(100), options);
  EXPECT_EQ(log.imu[89].clipped_gyro, 0);
  EXPECT_EQ(log.imu[90].clipped_gyro, 4);
  EXPECT_EQ(log.imu[0].clipped_accel, 4);
  EXPECT_EQ(log.counts.imu_clipped, 100u);
}

TEST(Condition, AGapIsFilledAndMarked) {
  for (const bool increments : {false, true}) {
    Recording r = recording(100, increments);
    drop_rows(r.imu, 40, 20);
    const Log log = condition(r, {});
    EXPECT_EQ(log.counts.imu_gaps, 1u);
    ASSERT_EQ(log.imu.size(), 100u);
    EXPECT_FALSE(log.imu[39].gap);
    for (std::size_t i = 40; i < 60; ++i) {
      EXPECT_TRUE(log.imu[i].gap);
      EXPECT_LT((log.imu[i].dtheta - Vector3d(0.1, 0.2, 0.01 * static_cast<double>(i)) * 0.01).norm(), 1e-9) << i;
    }
    EXPECT_FALSE(log.imu[60].gap);
    expect_contiguous(log);
  }
}

TEST(Condition, AGapOfInstantaneousRows) {
  ConditioningOptions options;
  options.imu.instantaneous = true;
  Recording r = recording(100);
  drop_rows(r.imu, 40, 20);
  const Log log = condition(r, options);
  EXPECT_EQ(log.counts.imu_gaps, 1u);
  ASSERT_EQ(log.imu.size(), 99u);
  expect_contiguous(log);
  EXPECT_NEAR(total_rotation(log).z(), 0.99 * 0.99 / 2, 1e-9);  // a ramp: the line is what was
}

TEST(Condition, ALateTimeStampIsNoGap) {
  Recording r = recording(100);
  r.imu.time[50] += 0.008;
  const Log log = condition(r, {});
  EXPECT_EQ(log.counts.imu_gaps, 0u);
  EXPECT_EQ(log.imu.size(), 100u);
}

TEST(Condition, ASilentIMUIsRefused) {
  Recording r = recording(100);
  for (std::size_t i = 50; i < 100; ++i) r.imu.time[i] += 400;
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(r, {}); }), "imu.csv: the IMU is silent from 1000.490"));
}

TEST(Condition, TheLongestGapIsAnOption) {
  Recording r = recording(100);
  for (std::size_t i = 50; i < 100; ++i) r.imu.time[i] += 400;
  ConditioningOptions options;
  options.behaviour.gaps.longest = 500;
  EXPECT_EQ(condition(r, options).counts.imu_gaps, 1u);
  Recording short_gap = recording(100);
  drop_rows(short_gap.imu, 40, 20);
  options.behaviour.gaps.longest = 0.1;
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(short_gap, options); }), "longer than 0.1 s"));
}

TEST(Condition, TimesInMillisecondsAreRefused) {
  Recording r = recording(100);
  for (double& t : r.imu.time) t *= 1000;
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(r, {}); }),
                       "imu.csv: the IMU's rows are 10 s apart; times in seconds"));
}

TEST(Condition, FixesInWorld) {
  const Recording r = recording(200);
  const Log log = condition(r, {});
  ASSERT_EQ(log.gnss.at(0).size(), 20u);
  EXPECT_LT(log.gnss[0][0].position.norm(), 1e-6);
  EXPECT_LT((log.gnss[0][0].sigma_position - Vector3d(1, 2, 3)).norm(), 1e-9);
  const GnssFix& last = log.gnss[0][19];
  EXPECT_GT(last.position.y(), 50);
  const Matrix3d R_wn = log.world.rotation_wn(last.position);
  EXPECT_LT((last.velocity->value - R_wn * Vector3d(3, 4, 0.5)).norm(), 1e-12);
  EXPECT_GT((last.velocity->value - Vector3d(3, 4, 0.5)).norm(), 1e-6);
}

// A thousand kilometres from the origin, sigmas and what "horizontal" means are still those of the place.
TEST(Condition, FixesFarFromTheOrigin) {
  Recording r = recording(200);
  r.gnss[0].fixes[0].velocity = {Vector3d(3, 4, 0), Vector3d(0.1, 0.2, std::numeric_limits<double>::infinity())};
  const Geodetic place = r.gnss[0].fixes[0].position;
  const World world({place.latitude + 0.15, place.longitude - 0.1, 0});
  const Log log = condition(r, {}, world);
  const GnssFix& fix = log.gnss.at(0).at(0);
  EXPECT_GT(fix.position.norm(), 9e5);
  EXPECT_EQ(fix.sigma_position, Vector3d(1, 2, 3));
  EXPECT_EQ(fix.velocity->sigma.head<2>(), Eigen::Vector2d(0.1, 0.2));
  EXPECT_FALSE(fix.velocity->has_down());
  EXPECT_LT((world.rotation_wn(fix.position).transpose() * fix.velocity->value - Vector3d(3, 4, 0)).norm(), 1e-12);
}

TEST(Condition, AVelocityWithoutDownStaysWithout) {
  Recording r = recording(200);
  for (GeodeticFix& fix : r.gnss[0].fixes) {
    fix.velocity = {Vector3d(3, 4, 0), Vector3d(0.1, 0.2, std::numeric_limits<double>::infinity())};
  }
  const FixVelocity velocity = *condition(r, {}).gnss.at(0).at(19).velocity;
  EXPECT_FALSE(velocity.has_down());
  EXPECT_LT((velocity.value - Vector3d(3, 4, 0)).norm(), 1e-3);
  EXPECT_LT((velocity.sigma.head<2>() - Eigen::Vector2d(0.1, 0.2)).norm(), 1e-3);
}

// Nothing but the horizontal speed tells that the body moves.
TEST(Condition, AVelocityWithoutDownTellsRestFromMotion) {
  Recording r = recording(1000);
  for (auto& rate : r.imu.gyro) rate.setZero();
  for (GeodeticFix& fix : r.gnss[0].fixes) {
    fix.velocity = {Vector3d(3, 4, 0), Vector3d(0.1, 0.1, std::numeric_limits<double>::infinity())};
  }
  EXPECT_TRUE(detect_rest(condition(r, {})).empty());
  for (GeodeticFix& fix : r.gnss[0].fixes) fix.velocity->value.setZero();
  EXPECT_TRUE(detect_rest(condition(r, {})).empty()) << "the positions leave their place";
  for (GeodeticFix& fix : r.gnss[0].fixes) fix.position = r.gnss[0].fixes.front().position;
  EXPECT_EQ(detect_rest(condition(r, {})).size(), 1u);
}

// A car with its engine running stands until 1025 s and rolls off, as quiet as before; from 1027 s on the road shakes
// it. Fixes that show rest end at `last_fix`.
double end_of_rest(double last_fix) {
  Recording r = recording(3500);
  for (std::size_t i = 0; i < r.imu.time.size(); ++i) {
    const double time = r.imu.time[i], shaken = time > 1027 ? 3 : 0.3;
    r.imu.gyro[i] = Vector3d(i % 2 ? shaken : -shaken, 0, 0);
    r.imu.accel[i] = kForce + Vector3d(time > 1025 ? 0.4 : 0, i % 2 ? shaken : -shaken, 0);
  }
  std::erase_if(r.gnss[0].fixes, [&](const GeodeticFix& fix) { return fix.time > last_fix; });
  for (GeodeticFix& fix : r.gnss[0].fixes) {
    fix.position = r.gnss[0].fixes.front().position;
    fix.velocity->value.setZero();
  }
  const std::vector<Interval> rest = detect_rest(condition(r, {}));
  EXPECT_EQ(rest.size(), 1u);
  return rest.empty() ? 0 : rest[0].end;
}

TEST(Condition, ASoftDepartureWithoutFixesEndsTheRest) {
  EXPECT_NEAR(end_of_rest(1010), 1025, 0.5);
  EXPECT_GT(end_of_rest(1028), 1026) << "fixes say that it stands: it has only tilted";
}

TEST(Condition, WhatCountsAsRestIsAnOption) {
  Recording r = recording(1000);
  for (auto& rate : r.imu.gyro) rate.setZero();
  for (GeodeticFix& fix : r.gnss[0].fixes) fix.velocity->value.setZero();
  ConditioningOptions options;
  EXPECT_TRUE(condition(r, options).rest.empty()) << "440 m away";
  options.behaviour.rest.sway_distance = 1000;
  EXPECT_EQ(condition(r, options).rest.size(), 1u);
  options.behaviour.rest.shortest = 30;
  EXPECT_TRUE(condition(r, options).rest.empty()) << "10 s long";
  options.behaviour.rest.shortest = 1;
  for (GeodeticFix& fix : r.gnss[0].fixes) fix.velocity->value.x() = 0.3;
  EXPECT_TRUE(condition(r, options).rest.empty()) << "faster than a sway";
  options.behaviour.rest.sway = 0.4;
  EXPECT_EQ(condition(r, options).rest.size(), 1u);
}

TEST(Condition, OutagesAndFixesOutsideAreCounted) {
  ConditioningOptions options;
  options.outages = {{1000.5, 1000.75}};
  options.span = {1000.295, 1001.505};
  Recording counted = recording(200);
  counted.gnss[0].without_fix = 7;
  const Log log = condition(counted, options);
  EXPECT_EQ(log.counts.gnss_without_fix.at(0), 7u);
  EXPECT_EQ(log.counts.gnss_withheld.at(0), 3u);      // 1000.5 1000.6 1000.7
  EXPECT_EQ(log.counts.gnss_outside.at(0), 3u + 4u);  // before 1000.29; after 1001.5
  EXPECT_EQ(log.gnss[0].size() + 3 + 7, 20u);
  EXPECT_NEAR(log.imu.front().time, 1000.30, 1e-9);
  EXPECT_NEAR(log.imu.back().time, 1001.50, 1e-9);
}

TEST(Condition, FixesOfOtherSensorsOutsideAreCounted) {
  Recording r = recording(200);
  const double end = r.imu.time.back();
  r.speed = {"speed.csv", {{1000.5, 1, 0.1}, {end + 1, 1, 0.1}}};
  r.height = {"height.csv", {{990, 1, 0.1}, {1000.5, 1, 0.1}, {end + 1, 1, 0.1}}};
  r.heading = {"heading.csv", {{1000.5, 1, 0.1}, {1000.6, 1, 0.1}}};
  r.speed.repaired.dropped = 2;
  const Log log = condition(r, {});
  EXPECT_EQ(log.counts.speed_outside, 1u);
  EXPECT_EQ(log.counts.height_outside, 2u);
  EXPECT_EQ(log.counts.heading_outside, 0u);
  EXPECT_EQ(log.counts.speed_repaired.dropped, 2u);
  EXPECT_EQ(log.height.size(), 1u);
  r.speed.fixes.erase(r.speed.fixes.begin());
  EXPECT_THROW(condition(r, {}), DataError);
}

TEST(Condition, AttitudeInWorld) {
  Recording r = recording(200);
  const Vector3d angles = Vector3d(5, -10, 200) * kDegree, sigma = Vector3d(0.1, 0.2, 0.5) * kDegree;
  r.attitude.push_back({"attitude.csv", {{1001.5, angles, sigma}, {1005, angles, sigma}}});
  const Log log = condition(r, {});
  ASSERT_EQ(log.attitude.at(0).size(), 1u);
  EXPECT_EQ(log.counts.attitude_outside.at(0), 1u);
  const AttitudeFix& fix = log.attitude[0][0];
  const Matrix3d R_wn = log.world.rotation_wn(log.gnss[0][15].position);
  EXPECT_LT(
      (to_euler(Quaterniond(R_wn.transpose()) * fix.q_wr) - (angles - Vector3d(0, 0, 2 * std::numbers::pi))).norm(),
      1e-9);
  EXPECT_LT(
      (euler_sigma(Quaterniond(R_wn.transpose()) * fix.q_wr, R_wn.transpose() * fix.covariance * R_wn) - sigma).norm(),
      1e-12);
}

TEST(Condition, AWeekThatRollsOverBeforeTheFirstFix) {
  Recording r = recording(200);
  for (double& t : r.imu.time) t += 604800;  // the IMU began in the week before
  EXPECT_EQ(condition(r, {}).gnss[0].size(), 20u);
}

TEST(Condition, SaysWhatIsMissing) {
  Recording none = recording(100);
  none.gnss.clear();
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(none, {}); }), "no GNSS"));
  Recording apart = recording(100);
  for (double& t : apart.imu.time) t += 1000;
  const std::string message = message_of<DataError>([&] { condition(apart, {}); });
  EXPECT_TRUE(contains(
      message,
      "imu.csv:1: no time in common with GNSS: the IMU covers 1999.990 to 2000.990 s, gnss.csv covers 1000.000"));
  EXPECT_TRUE(contains(message, "clock"));
  ConditioningOptions options;
  options.span = {5000, 6000};
  EXPECT_TRUE(
      contains(message_of<DataError>([&] { condition(recording(100), options); }), "0 IMU rows lie within the span"));
  options.span = {};
  options.outages = {{0, 5000}};
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(recording(100), options); }), "withheld"));
  Recording empty = recording(0);
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(empty, {}); }), "no rows"));
  Recording attitude = recording(100);
  attitude.attitude.push_back({"attitude.csv", {{5000, Vector3d::Zero(), Vector3d::Ones()}}});
  EXPECT_TRUE(contains(message_of<DataError>([&] { condition(attitude, {}); }), "reference attitude"));
}

TEST(RecordedDrive, Conditions) {
  PISTE_REQUIRE_DATASETS();
  const auto drive = test::datasets() / "drive";
  Recording r;
  r.imu = read_imu({drive / "imu.txt", LogFormat::kKfGins});
  r.gnss.push_back(read_gnss({drive / "gnss_1934_sf.pos", LogFormat::kRtklibPos}));
  const Log log = condition(r, {});
  EXPECT_EQ(log.counts.imu_gaps, 0u);
  EXPECT_EQ(log.imu.size(), 54858u);
  EXPECT_EQ(log.gnss[0].size() + log.counts.gnss_outside[0], 2197u);
  expect_contiguous(log);
}

}  // namespace
}  // namespace piste
