// What an IMU's log tells of itself, clean and spoilt.

#include "piste/inspect/imu_health.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "piste/math/units.h"
#include "support/simulated_case.h"

namespace piste {
namespace {

const ImuRecording& clean() {
  static const ImuRecording recording = test::make_case("ski", 40, 1).simulation.imus[0].recording;
  return recording;
}

ImuRecording scaled(double gyro, double accel) {
  ImuRecording imu = clean();
  for (Vector3d& w : imu.gyro) w *= gyro;
  for (Vector3d& f : imu.accel) f *= accel;
  return imu;
}

std::vector<LogFault> severe(const ImuRecording& imu, const RowFaults& faults = {}) {
  std::vector<LogFault> found;
  for (const Suspicion& s : suspicions(imu_health(imu), faults, "imu.csv")) {
    EXPECT_EQ(s.file, "imu.csv");
    EXPECT_FALSE(s.what.empty());
    EXPECT_FALSE(s.remedy.empty());
    if (is_severe(s.fault)) found.push_back(s.fault);
  }
  return found;
}

using Faults = std::vector<LogFault>;

TEST(ImuHealth, OfACleanLog) {
  const ImuHealth h = imu_health(clean());
  EXPECT_EQ(severe(clean()), Faults{});
  EXPECT_NEAR(h.sampling.rate(), 100, 0.1);
  EXPECT_LT(h.sampling.jitter, 1e-5);
  EXPECT_TRUE(h.sampling.gaps.empty());
  ASSERT_FALSE(h.rest.empty());
  EXPECT_NEAR(h.rest.front().start, clean().time.front(), 1.1);
  EXPECT_NEAR(h.rest.front().end, clean().time.front() + 20, 2);
  EXPECT_NEAR(h.force, 9.81, 0.25);  // with a scale of 2 %
  EXPECT_FALSE(h.force_unit);
  // What the sensor file says: 0.05 deg/s/√Hz and 200 µg/√Hz; the sway of a body is not noise, or hardly.
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(h.gyro.noise(axis) / kDegree, 0.05, 0.005);
    EXPECT_NEAR(h.accel.noise(axis), 200e-6 * 9.80665, 0.0005);
  }
}

TEST(ImuHealth, OfIncrements) {
  ImuRecording imu = clean();
  imu.increments = true;
  for (std::size_t i = 0; i < imu.time.size(); ++i) {
    imu.gyro[i] *= 0.01;
    imu.accel[i] *= 0.01;
  }
  EXPECT_EQ(severe(imu), Faults{});
  EXPECT_NEAR(imu_health(imu).gyro.noise(0) / kDegree, 0.05, 0.005);
}

TEST(ImuHealth, NamesTheUnitOfForces) {
  EXPECT_EQ(severe(scaled(1, 1 / 9.80665)), Faults{LogFault::kAccelG});
  EXPECT_EQ(severe(scaled(1, 1000 / 9.80665)), Faults{LogFault::kAccelG});
  EXPECT_EQ(severe(scaled(1, 9.80665)), Faults{LogFault::kAccelMetres});
  EXPECT_EQ(severe(scaled(0.01, 0.01)), Faults{LogFault::kIncrementsForRates});
  ImuRecording rates = clean();
  rates.increments = true;
  EXPECT_EQ(severe(rates).front(), LogFault::kRatesForIncrements);
  EXPECT_NEAR(imu_health(rates).force_unit->factor, 100, 1e-6);
}

TEST(ImuHealth, NamesDegreesThatNoBodyTurnsAt) {
  ImuRecording imu = test::make_case("giant_slalom", 40, 1).simulation.imus[0].recording;
  EXPECT_EQ(severe(imu), Faults{});
  for (Vector3d& w : imu.gyro) w /= kDegree;
  const auto found = severe(imu);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front(), LogFault::kGyroDegrees);
}

TEST(ImuHealth, MissesGravity) {
  ImuRecording imu = clean();
  const Vector3d gravity = imu_health(imu).accel.mean;
  for (Vector3d& f : imu.accel) f -= gravity;
  EXPECT_EQ(severe(imu), Faults{LogFault::kNoGravity});
}

TEST(ImuHealth, SeesOtherTimes) {
  const auto with_times = [](auto&& change) {
    ImuRecording imu = clean();
    for (double& t : imu.time) t = change(t);
    return severe(imu);
  };
  const double first = clean().time.front();
  EXPECT_EQ(with_times([](double t) { return 1000 * t; }).front(), LogFault::kTimeUnit);
  EXPECT_EQ(with_times([](double t) { return 1e6 * t; }).front(), LogFault::kTimeUnit);
  EXPECT_EQ(with_times([&](double t) { return t - first + 1.7e9; }), Faults{LogFault::kNotSecondsOfWeek});
  EXPECT_EQ(with_times([&](double t) { return t - first - 10; }), Faults{}) << "since another instant";
}

// Increments over a second are as large as rates: gravity is in either.
TEST(ImuHealth, AtARowASecondRatesAreNoIncrements) {
  for (const double interval : {0.75, 1.0, 1.25}) {
    ImuRecording imu;
    for (int i = 0; i < 300; ++i) {
      imu.time.push_back(500 + i * interval);
      imu.gyro.emplace_back(0.01 * (i % 5), 0.02 * (i % 7), 0.1 * std::sin(0.2 * i));
      imu.accel.emplace_back(0.3 * std::sin(0.1 * i), 0.2 * (i % 3), -9.6);
    }
    EXPECT_FALSE(imu_health(imu).force_unit) << interval;
  }
}

TEST(ImuHealth, SeesWhatIsBroken) {
  ImuRecording gap = clean();
  const auto drop = [](auto& rows) { rows.erase(rows.begin() + 3000, rows.begin() + 3070); };
  drop(gap.time);
  drop(gap.gyro);
  drop(gap.accel);
  EXPECT_EQ(severe(gap), Faults{LogFault::kGaps});
  const ImuHealth h = imu_health(gap);
  ASSERT_EQ(h.sampling.gaps.size(), 1u);
  EXPECT_EQ(h.sampling.missing, 70u);
  EXPECT_NEAR(h.sampling.gaps[0].end - h.sampling.gaps[0].start, 0.71, 0.001);

  ImuRecording spike = clean();
  spike.gyro[4000].y() = 1e6;
  EXPECT_EQ(severe(spike), Faults{LogFault::kSpikes});

  ImuRecording frozen = clean();
  for (std::size_t i = 3000; i < 3100; ++i) {
    frozen.gyro[i] = frozen.gyro[3000];
    frozen.accel[i] = frozen.accel[3000];
  }
  EXPECT_EQ(severe(frozen), Faults{LogFault::kFrozenSensor});

  ImuRecording clipped = clean();
  for (Vector3d& w : clipped.gyro) w = w.cwiseMax(-0.3).cwiseMin(0.3);
  EXPECT_EQ(severe(clipped), Faults{});  // the filter can live with it
  EXPECT_NEAR(imu_health(clipped).gyro.limit.maxCoeff(), 0.3, 1e-9);
  EXPECT_EQ(suspicions(imu_health(clipped), {}, "imu.csv").front().fault, LogFault::kClipped);
}

// A calm body, of which rates are written in whole degrees a second: they stand at one step for most of the time.
TEST(ImuHealth, RoundedRatesOfACalmBodyAreNoLimit) {
  ImuRecording calm = clean();
  for (std::size_t i = 0; i < calm.gyro.size(); ++i) calm.gyro[i] = kDegree * Vector3d(i % 9 == 0 ? 0 : 1, 0, -3);
  const ImuHealth h = imu_health(calm);
  EXPECT_EQ(h.gyro.limit, Vector3d::Zero());
  EXPECT_NEAR(h.gyro.repeated.x(), 7. / 9, 0.01);
  EXPECT_EQ(suspicions(h, {}, "imu.csv").front().fault, LogFault::kQuantised);
  ImuRecording flat = clean();
  for (Vector3d& w : flat.gyro) w.x() = 0;
  EXPECT_EQ(std::ranges::count(suspicions(imu_health(flat), {}, "imu.csv"), LogFault::kQuantised, &Suspicion::fault),
            0);
}

TEST(ImuHealth, SaysWhichRowsWereRefused) {
  RowFaults faults;
  faults.add({RowFault::Kind::kNotFinite, 17, "field 3, `nan`, must be finite"});
  faults.add({RowFault::Kind::kTimeBack, 40, "time does not increase"});
  const auto found = suspicions(imu_health(clean()), faults, "imu.csv");
  ASSERT_GE(found.size(), 2u);
  EXPECT_EQ(found[0].fault, LogFault::kBadRows);
  EXPECT_NE(found[0].what.find("17"), std::string::npos);
  EXPECT_EQ(found[1].fault, LogFault::kTimeBack);
}

TEST(ImuHealth, WithoutRestNoNoiseIsClaimed) {
  const ImuRecording all = clean();
  ImuRecording imu;
  for (std::size_t i = 3000; i < 6000; ++i) {
    imu.time.push_back(all.time[i]);
    imu.gyro.push_back(all.gyro[i]);
    imu.accel.push_back(all.accel[i]);
  }
  const ImuHealth h = imu_health(imu);
  EXPECT_TRUE(h.rest.empty());
  EXPECT_TRUE(std::isnan(h.gyro.noise.x()));
  EXPECT_EQ(severe(imu), Faults{});
}

}  // namespace
}  // namespace piste
