// When a body stands, from logs that are made up of stretches: what receivers, rates and forces say of each.

#include "piste/condition/rest_detection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "support/random.h"

namespace piste::test {
namespace {

constexpr double kStep = 0.01, kBegin = 500;
constexpr double kQuietGyro = 0.002, kQuietForce = 0.02;

/// What the body does for a while.
struct Stretch {
  double duration = 10, speed = 0;                ///< s; m/s to the north
  double gyro = kQuietGyro, force = kQuietForce;  ///< rms of rate and force [rad/s, m/s²]
  double turn = 0;                                ///< rad/s
  double velocity = 0.05, position = 0.5;  ///< 1-sigma of the fixes; 0: there are no fixes, or none with a velocity
};

const Stretch kMoves{.speed = 5, .gyro = 0.2, .force = 1};

Log log_of(const std::vector<Stretch>& stretches) {
  Log log;
  log.world = World({0.8, 0.1, 300});
  log.gnss.resize(1);
  Random random(1);
  double time = kBegin;
  Vector3d p = Vector3d::Zero();
  std::size_t row = 0;
  for (const Stretch& s : stretches) {
    for (int i = 0; i < std::lround(s.duration / kStep); ++i, ++row) {
      ImuSample sample;
      sample.interval = kStep;
      sample.dtheta = kStep * (random.vector(s.gyro) + Vector3d(0, 0, s.turn));
      sample.dvel = kStep * (random.vector(s.force) - Vector3d(0, 0, 9.81));
      time = kBegin + static_cast<double>(row + 1) * kStep;
      sample.time = time;
      log.imu.push_back(sample);
      p.x() += kStep * s.speed;
      if (row % 20 != 0 || s.position == 0) continue;
      GnssFix fix{time, p, Vector3d::Constant(s.position), {}};
      if (s.velocity > 0)
        fix.velocity =
            FixVelocity{Vector3d(s.speed, 0, 0) + random.vector(0.3 * s.velocity), Vector3d::Constant(s.velocity)};
      log.gnss[0].push_back(fix);
    }
  }
  return log;
}

/// The rests as seconds from the beginning.
std::vector<Interval> rests_of(const Log& log, const RestOptions& options = {}) {
  std::vector<Interval> rests = detect_rest(log, options);
  for (Interval& rest : rests) {
    rest.start -= kBegin;
    rest.end -= kBegin;
  }
  return rests;
}

void expect_rests(const std::vector<Interval>& rests, const std::vector<Interval>& expected, double tolerance = 1) {
  ASSERT_EQ(rests.size(), expected.size());
  for (std::size_t i = 0; i < rests.size(); ++i) {
    EXPECT_NEAR(rests[i].start, expected[i].start, tolerance) << i;
    EXPECT_NEAR(rests[i].end, expected[i].end, tolerance) << i;
  }
}

TEST(Rest, IsWhereReceiverAndImuAreQuiet) {
  const RestOptions options;
  expect_rests(rests_of(log_of({{}, kMoves, {}})), {{0, 10}, {20, 30}});
  // An engine that runs shakes a car that stands; whoever carries it moves while its fixes stand.
  expect_rests(rests_of(log_of({{}, kMoves, {.gyro = 10 * options.as_quiet * kQuietGyro}})), {{0, 10}});
  expect_rests(rests_of(log_of({{}, kMoves, {.force = 10 * options.as_quiet * kQuietForce}})), {{0, 10}});
  // It rolls without a sound.
  expect_rests(rests_of(log_of({{}, kMoves, {.speed = 1}})), {{0, 10}});
}

TEST(Rest, IsSeenByPositionsWhereThereAreNoVelocities) {
  const std::vector<Stretch> run{{.velocity = 0, .position = 0.05},
                                 {.speed = 5, .gyro = 0.2, .force = 1, .velocity = 0, .position = 0.05},
                                 {.velocity = 0, .position = 0.05}};
  expect_rests(rests_of(log_of(run)), {{0, 10}, {20, 30}});
  // Coarse positions show it over a longer span; very coarse ones never do, and the rates say too little alone.
  std::vector<Stretch> coarse = run;
  for (Stretch& s : coarse) s.position = 0.2;
  expect_rests(rests_of(log_of(coarse)), {{0, 10}, {20, 30}}, 4);
  for (Stretch& s : coarse) s.position = 100;
  EXPECT_TRUE(rests_of(log_of(coarse)).empty());
  // One fix within the reach shows no speed.
  Log rare = log_of(run);
  rare.gnss[0].resize(1);
  EXPECT_TRUE(rests_of(rare).empty());
}

// Without fixes the rates decide alone, by the level that they had where fixes showed a rest.
// A rover at 0.4 m/s that stops every half minute. Fixes of 0.8 m resolve its speed over half a minute alone, in which
// it stands and drives, so that no window certainly moves and most that pass for rest do move.
TEST(Rest, OfASlowBodyIsNotItsSlowMotion) {
  const Stretch stands{.duration = 6, .velocity = 0, .position = 0.8};
  const Stretch drives{.duration = 7, .speed = 0.4, .gyro = 0.05, .force = 0.5, .velocity = 0, .position = 0.8};
  std::vector<Stretch> all{{.duration = 25, .velocity = 0, .position = 0.8}};
  for (int i = 0; i < 12; ++i) {
    all.push_back(drives);
    all.push_back(stands);
  }
  const std::vector<Interval> rests = rests_of(log_of(all));
  ASSERT_FALSE(rests.empty());
  double rested = 0;
  for (const Interval& rest : rests) {
    rested += rest.end - rest.start;
    if (rest.end <= 25) continue;
    const double began = std::fmod(rest.start - 25, 13), ended = began + rest.end - rest.start;
    EXPECT_TRUE(began > 6.5 && ended < 13.5) << rest.start << " to " << rest.end;
  }
  EXPECT_GT(rested, 25) << "of 97 s";
}

TEST(Rest, WithoutFixesIsQuieterThanMotion) {
  // So long that no fix is near its middle.
  const Stretch blind{.duration = 60, .velocity = 0, .position = 0};
  expect_rests(rests_of(log_of({{}, kMoves, blind, kMoves})), {{0, 10}, {20, 80}}, 17);
  Stretch shaken = blind, pushed = blind;
  shaken.gyro = 0.1;
  pushed.force = 0.5;
  for (const Stretch& s : {shaken, pushed}) expect_rests(rests_of(log_of({{}, kMoves, s, kMoves})), {{0, 10}});
  // Nobody said what a rest is like.
  EXPECT_TRUE(rests_of(log_of({kMoves, blind})).empty());
  // It moved as quietly as it stood: what cannot be distinguished is no rest.
  Stretch glides = kMoves;
  glides.gyro = 0.5 * kQuietGyro;
  glides.force = 0.5 * kQuietForce;
  expect_rests(rests_of(log_of({{}, glides, blind})), {{0, 10}});
}

TEST(Rest, EndsAtAGap) {
  Log log = log_of({{}, kMoves});
  log.imu[400].gap = GapNoise{};
  expect_rests(rests_of(log), {{0, 4}, {4, 10}});
  log.imu.erase(log.imu.begin() + 380, log.imu.begin() + 450);
  expect_rests(rests_of(log), {{0, 3.8}, {4.5, 10}});
  log.imu.resize(5);
  EXPECT_TRUE(rests_of(log).empty()) << "too short for a window";
  log.imu.clear();
  EXPECT_TRUE(rests_of(log).empty());
}

// Ten centimetres a second are within the noise of the velocities; over a minute the positions show it. What is left of
// the rest is what stands.
TEST(Rest, IsNotWhereTheBodyLeavesItsPlaceOrTurns) {
  const Stretch stands{.duration = 64, .velocity = 0.3, .position = 0.02};
  Stretch creeps = stands;
  creeps.speed = 0.1;
  expect_rests(rests_of(log_of({stands, stands, kMoves})), {{0, 128}});
  std::vector<Stretch> swinging{stands};
  for (int i = 0; i < 20; ++i)
    swinging.push_back({.duration = 3, .turn = i % 2 == 0 ? 0.1 : -0.1, .velocity = 0.3, .position = 0.02});
  swinging.push_back(kMoves);
  for (const std::vector<Stretch>& run : {std::vector<Stretch>{stands, creeps, kMoves}, swinging}) {
    double standing = 0, beyond = 0;
    for (const Interval& rest : rests_of(log_of(run))) {
      standing += std::min(rest.end, 64.0) - std::min(rest.start, 64.0);
      beyond += std::max(rest.end, 64.0) - std::max(rest.start, 64.0);
    }
    EXPECT_GT(standing, 55);
    EXPECT_LT(beyond, 5);
  }
}

TEST(Rest, OfTwoImusIsThatOfTheReference) {
  AlignedImus imus;
  imus.interval = kStep;
  Random random(2);
  for (int i = 0; i < 3000; ++i) {
    const bool moves = i >= 1000 && i < 2000;
    imus.time.push_back(kBegin + (i + 1) * kStep);
    imus.reference_gyro.push_back(random.vector(moves ? 0.3 : 0.001));
    imus.reference_accel.push_back(random.vector(moves ? 2 : 0.01) - Vector3d(0, 0, 9.81));
    imus.usable.push_back(i != 400);
  }
  const auto rests = [&] {
    std::vector<Interval> found = detect_rest(imus);
    for (Interval& rest : found) {
      rest.start -= kBegin;
      rest.end -= kBegin;
    }
    return found;
  };
  expect_rests(rests(), {{0, 4}, {4, 10}, {20, 30}});
  AlignedImus whole = imus;
  for (std::size_t i = 2000; i < 3000; ++i) imus.reference_gyro[i].z() += 0.2;
  expect_rests(rests(), {{0, 4}, {4, 10}});  // it turns, however steadily
  imus = whole;
  for (std::size_t i = 2000; i < 3000; ++i) imus.reference_gyro[i] = random.vector(0.3);
  expect_rests(rests(), {{0, 4}, {4, 10}});
  imus = whole;
  for (std::size_t i = 2000; i < 3000; ++i) imus.reference_accel[i] += random.vector(2);
  expect_rests(rests(), {{0, 4}, {4, 10}});
  imus.time.resize(5);
  EXPECT_TRUE(rests().empty());
}

TEST(Rest, SamplesWithinItAreMarked) {
  Log log = log_of({{.duration = 1}});
  log = with_rest(std::move(log), {{kBegin + 0.2, kBegin + 0.4}, {kBegin + 0.695, kBegin + 0.8}});
  for (const ImuSample& s : log.imu) {
    const double end = s.time - kBegin, start = end - kStep;
    const bool within = (start > 0.2 - 1e-6 && end < 0.4 + 1e-6) || (start > 0.695 - 1e-6 && end < 0.8 + 1e-6);
    EXPECT_EQ(s.at_rest, within) << end;
  }
  EXPECT_EQ(log.rest.size(), 2U);
}

}  // namespace
}  // namespace piste::test
