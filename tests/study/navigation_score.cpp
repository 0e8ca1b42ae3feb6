#include "piste/study/navigation_score.h"

#include <gtest/gtest.h>

#include "piste/core/error.h"
#include "piste/math/units.h"
#include "support/simulated_case.h"

namespace piste {
namespace {

using test::Case;
using test::make_case;

TEST(Outages, LieWholeWithinTheRun) {
  const std::vector<Interval> windows = outages({.first = 10, .length = 10, .every = 20}, {100, 161});
  ASSERT_EQ(windows.size(), 3U);
  EXPECT_EQ(windows[0].start, 110);
  EXPECT_EQ(windows[2].end, 160);
  EXPECT_TRUE(outages({.first = 10, .length = 10, .every = 20}, {100, 119}).empty());
}

// A run of one MT-9A beside a reference without errors.
struct Known {
  Case c = make_case("easy_ski", 30, 4);
  Log log = c.log();
  Interval run = c.simulation.plate.under_way();
  BodyMounting body{c.scenario.imus[0].q_rb, c.scenario.imus[0].p_rb_r};
  ReferenceTrack track;
  KnownErrors truth;

  Known() : track(solution(), samples(), run) {
    const SimulatedImu& imu = c.simulation.imus[0];
    truth.gyro.bias = imu.gyro.bias + imu.gyro.run.drift;
    truth.accel.bias = imu.accel.bias + imu.accel.run.drift;
    truth.gyro.gain = imu.gyro.scale.asDiagonal();
    truth.accel.gain = imu.accel.scale.asDiagonal();
  }
  std::vector<ImuSample> samples() const {
    std::vector<ImuSample> out;
    for (double t = run.start - 1; t < run.end + 1; t += 0.005) {
      const MeanInertial mean = c.simulation.plate.mean(t - 0.005, t);
      out.push_back({.time = t, .interval = 0.005, .dtheta = 0.005 * mean.gyro, .dvel = 0.005 * mean.accel});
    }
    return out;
  }
  Solution solution() const {
    const Truth& plate = c.simulation.plate;
    Solution out(StateLayout(), plate.world());
    for (double t = run.start - 1; t < run.end + 1; t += 0.005) {
      const TruthState is = plate.at(t);
      Estimate x;
      x.q_wb = is.q_wb;
      x.v_wb = is.v_wb;
      x.p_wb = is.p_wb;
      out.append(t, x, {});
    }
    return out;
  }
  Course course() const { return {log, c.options, run, track, body}; }
};

TEST(NavigationScore, TrueErrorsAreBestAndWorseOnesWorse) {
  const Known k;
  const Course course = k.course();
  EXPECT_EQ(course.windows(), 2U);
  const NavigationScore truth = course.score(Method::kTruth, k.truth),
                        nothing = course.score(Method::kNothing, KnownErrors{});
  EXPECT_EQ(truth.method, Method::kTruth);
  EXPECT_LT(truth.position_rmse, 0.03);
  EXPECT_LT(truth.velocity_rmse, 0.04);
  EXPECT_LT(truth.attitude_rmse, 0.3 / kDegreesPerRadian);
  EXPECT_LT(truth.outage_drift, 4);
  EXPECT_GT(nothing.attitude_rmse, 3 * truth.attitude_rmse);
  EXPECT_GT(nothing.outage_drift, 5 * truth.outage_drift);

  KnownErrors wrong = k.truth;
  wrong.accel.bias.y() += 0.1;
  const NavigationScore tilted = course.score(Method::kRest, wrong);
  EXPECT_GT(tilted.attitude_rmse, truth.attitude_rmse + 0.1 / kDegreesPerRadian);
  EXPECT_GT(tilted.outage_drift, 1.5 * truth.outage_drift);
}

TEST(NavigationScore, WithoutAnythingFedTheReplayEstimatesItself) {
  const Known k;
  const Course course = k.course();
  const NavigationScore own = course.score(Method::kInTheFilter, std::nullopt),
                        nothing = course.score(Method::kNothing, KnownErrors{});
  EXPECT_LT(own.attitude_rmse, 0.5 * nothing.attitude_rmse);
  EXPECT_LT(own.outage_drift, 0.5 * nothing.outage_drift);
}

TEST(NavigationScore, NeedsAReferenceInTheRun) {
  const Known k;
  const ReferenceTrack elsewhere(k.solution(), k.samples(), {0, 1});
  EXPECT_THROW(Course(k.log, k.c.options, k.run, elsewhere, k.body), DataError);
}

}  // namespace
}  // namespace piste
