#include "condition/spikes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "piste/condition/pipeline.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/places.h"
#include "support/random.h"

namespace piste {
namespace {

constexpr double kSpikeStep = 0.01;

// 20 s of turns of a skier at 100 Hz with noise.
ImuRecording turns(bool increments = false) {
  test::Random random(3);
  ImuRecording imu;
  imu.file = "imu.csv";
  imu.increments = increments;
  const double unit = increments ? kSpikeStep : 1;
  for (int i = 0; i < 2000; ++i) {
    const double t = kSpikeStep * i;
    imu.time.push_back(1000 + t);
    imu.gyro.emplace_back(unit * (Vector3d(1.2 * std::sin(2 * t), 0.4 * std::cos(3 * t), 0.8) + random.vector(0.02)));
    imu.accel.emplace_back(unit * (Vector3d(3 * std::sin(2 * t), 0, -9.8) + random.vector(0.3)));
  }
  return imu;
}

Log conditioned(const ImuRecording& imu, bool instantaneous = false) {
  ConditioningOptions options;
  options.imu.instantaneous = instantaneous;
  return condition_imu(imu, options);
}

double distance(const Log& log, const Log& other) {
  Vector3d most = Vector3d::Zero();
  for (std::size_t i = 0; i < log.imu.size(); ++i) {
    most = most.cwiseMax((log.imu[i].dtheta - other.imu[i].dtheta).cwiseAbs());
  }
  return most.maxCoeff();
}

std::size_t spikes_of(const LogFile& log) { return conditioned(read_imu(log)).counts.imu_spikes; }

TEST(Spikes, CleanTurnsHaveNone) {
  for (const bool increments : {false, true}) EXPECT_EQ(conditioned(turns(increments)).counts.imu_spikes, 0u);
}

TEST(Spikes, OneAndTwoRowsAreMendedMarkedAndCounted) {
  for (const bool increments : {false, true}) {
    const ImuRecording clean = turns(increments);
    ImuRecording spoilt = clean;
    const double spike = 1117 * kDegree * (increments ? kSpikeStep : 1);
    spoilt.gyro[700].y() += spike;
    spoilt.gyro[1300].z() -= spike;
    spoilt.gyro[1301].z() -= 0.7 * spike;
    spoilt.accel[1301].x() += 300 * (increments ? kSpikeStep : 1);
    const Log log = conditioned(spoilt), good = conditioned(clean);
    EXPECT_EQ(log.counts.imu_spikes, 3u);
    for (std::size_t i = 0; i < log.imu.size(); ++i) {
      EXPECT_EQ(log.imu[i].interpolated.has_value(), i == 700 || i == 1300 || i == 1301) << i;
    }
    EXPECT_LT(distance(log, good), 0.15 * kSpikeStep);
    EXPECT_NEAR(log.imu[700].interpolated->gyro, 0.02 * std::sqrt(1.5 * kSpikeStep), 0.001);  // noise of row less line
    EXPECT_EQ(log.imu[700].interpolated->accel, 0);
    EXPECT_GT(log.imu[1301].interpolated->accel, 0);
  }
}

TEST(Spikes, AreLeftAloneIfTheOptionsSaySo) {
  ImuRecording spoilt = turns();
  spoilt.gyro[700].y() += 20;
  ConditioningOptions options;
  options.behaviour.spikes.mend = false;
  const Log left = condition_imu(spoilt, options);
  EXPECT_EQ(left.counts.imu_spikes, 0u);
  EXPECT_FALSE(left.imu[700].interpolated);
  EXPECT_DOUBLE_EQ(left.imu[700].dtheta.y(), left.imu[700].interval * spoilt.gyro[700].y());
  options.behaviour.spikes.mend = true;
  EXPECT_EQ(condition_imu(spoilt, options).counts.imu_spikes, 1u);
  options.behaviour.spikes.gyro = {.per_second = 5000, .least = 1};
  EXPECT_EQ(condition_imu(spoilt, options).counts.imu_spikes, 0u) << "no more than this body does";
}

TEST(Spikes, OfInstantaneousSamplesMarkBothIntervals) {
  ImuRecording spoilt = turns();
  spoilt.gyro[700].y() += 20;
  const Log log = conditioned(spoilt, true), good = conditioned(turns(), true);
  EXPECT_EQ(log.counts.imu_spikes, 1u);
  EXPECT_LT(distance(log, good), 0.15 * kSpikeStep);
  EXPECT_TRUE(log.imu[699].interpolated && log.imu[700].interpolated);
  EXPECT_FALSE(log.imu[698].interpolated || log.imu[701].interpolated);
}

TEST(Spikes, AKnockThatRingsIsMotion) {
  ImuRecording knock = turns();
  const double peak = 150;  // m/s²
  for (int i = 0; i < 30; ++i) knock.accel[900 + i].z() += peak * std::exp(-i / 3.0) * std::cos(1.5 * i);
  EXPECT_EQ(conditioned(knock).counts.imu_spikes, 0u);
}

TEST(Spikes, StepsThatComeBackAreMotion) {
  ImuRecording walk = turns();
  for (std::size_t i = 100; i < 2000; i += 90) walk.accel[i].z() -= 120;
  EXPECT_EQ(conditioned(walk).counts.imu_spikes, 0u);
}

TEST(Spikes, ThreeRowsAndAStepAreLeftAlone) {
  ImuRecording held = turns();
  for (std::size_t i = 900; i < 903; ++i) held.gyro[i].x() += 20;
  for (std::size_t i = 1500; i < 2000; ++i) held.gyro[i].y() += 20;
  EXPECT_EQ(conditioned(held).counts.imu_spikes, 0u);
}

TEST(Spikes, BesideAGapAreNotJudged) {
  ImuRecording gap = turns();
  gap.gyro[900].x() += 20;
  for (std::size_t i = 903; i < 2000; ++i) gap.time[i] += 0.5;
  EXPECT_EQ(conditioned(gap).counts.imu_spikes, 0u);
}

// Where the motion around is known on one side or near the ends of the log, that is enough; two rows are not.
TEST(Spikes, NeedSomeRowsOnEitherSide) {
  const SpikeOptions options;
  for (const auto& [row, is_one] : {std::pair{std::size_t{900}, true},
                                    {options.fewest + 1, true},
                                    {std::size_t{2}, false},
                                    {1999 - options.fewest - 1, true},
                                    {std::size_t{1997}, false},
                                    {std::size_t{1999}, false}}) {
    ImuRecording spoilt = turns();
    spoilt.gyro[row].x() += 20;
    EXPECT_EQ(conditioned(spoilt).counts.imu_spikes, is_one ? 1u : 0u) << row;
  }
  for (const std::size_t after : {20u, 3u}) {  // rows between a gap and the spike
    ImuRecording gap = turns();
    gap.gyro[900].x() += 20;
    for (std::size_t i = 900 - after; i < 2000; ++i) gap.time[i] += 0.5;
    EXPECT_EQ(conditioned(gap).counts.imu_spikes, after > options.fewest ? 1u : 0u) << after;
  }
}

TEST(Spikes, TheShippedRunHasNone) {
  EXPECT_EQ(spikes_of({.file = test::source_folder() + "/data/ski_run/mt9a_1.csv", .format = LogFormat::kCsv}), 0u);
}

TEST(Spikes, VibrationOfAQuadrotorAndACarAreMotion) {
  PISTE_REQUIRE_DATASETS();
  for (const std::string flight : {"flight_3", "flight_4"}) {
    for (int i = 1; i <= 4; ++i) {
      const std::string file =
          (test::datasets() / "quadrotor" / flight / ("imu_" + std::to_string(i) + ".csv")).string();
      EXPECT_EQ(spikes_of({.file = file, .format = LogFormat::kCsv}), 0u) << file;
    }
  }
  const std::string drive = (test::datasets() / "drive" / "imu.txt").string();
  EXPECT_EQ(spikes_of({.file = drive, .format = LogFormat::kKfGins}), 0u);
}

}  // namespace
}  // namespace piste
