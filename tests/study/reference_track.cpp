#include "piste/study/reference_track.h"

#include <gtest/gtest.h>

#include "piste/sim/simulation.h"
#include "support/scenario.h"

namespace piste {
namespace {

// What a perfect reference solution would say of the simulated plate.
struct Perfect {
  Truth plate;
  std::vector<ImuSample> imu;
  Solution solution;
};

Perfect perfect(const Scenario& scenario) {
  constexpr double kStep = 0.005;
  Simulation run = simulate(scenario, 3);
  Perfect out{run.plate, {}, Solution(StateLayout(), run.plate.world())};
  const double start = run.plate.under_way().start + 8;
  for (int k = 1; k <= 400; ++k) {
    const double t = start + k * kStep;
    const MeanInertial mean = run.plate.mean(t - kStep, t);
    out.imu.push_back({.time = t, .interval = kStep, .dtheta = kStep * mean.gyro, .dvel = kStep * mean.accel});
    const TruthState truth = run.plate.at(t);
    Estimate x;
    x.q_wb = truth.q_wb;
    x.v_wb = truth.v_wb;
    x.p_wb = truth.p_wb;
    out.solution.append(t, x, {});
  }
  return out;
}

Scenario short_slalom() {
  Scenario s = test::suite_scenario("ski_l1l2");
  test::shorten(s, 2, 20, 1);
  s.imus.resize(1);
  s.gnss.clear();
  s.attitude.clear();
  return s;
}

TEST(ReferenceTrack, KnowsABodyOnThePlateBetweenItsRows) {
  const Perfect p = perfect(short_slalom());
  const ReferenceTrack track(p.solution, p.imu, {p.imu.front().time, p.imu.back().time});
  const BodyMounting body{from_euler({0.03, -0.04, 1.2}), {0.6, 0.5, -0.3}};
  const Truth truth = p.plate.attached(body.q_rb, body.p_rb_r);
  for (double t = track.span().start + 0.1013; t < track.span().end - 0.1; t += 0.0417) {
    const ReferenceTrack::State seen = track.at(t, body);
    const TruthState is = truth.at(t);
    EXPECT_LT(seen.q_wb.angularDistance(is.q_wb), 2e-5);
    EXPECT_LT((seen.p_wb - is.p_wb).norm(), 2e-4);
    EXPECT_LT((seen.v_wb - is.v_wb).norm(), 2e-3);
  }
}

TEST(ReferenceTrack, IsTheSamePlaceInAnotherWorld) {
  const Perfect p = perfect(short_slalom());
  const ReferenceTrack track(p.solution, p.imu, {p.imu.front().time, p.imu.back().time});
  Geodetic origin = p.plate.world().origin();
  origin.latitude += 3e-4;
  origin.longitude -= 5e-4;
  origin.height += 700;
  const World other(origin);
  const ReferenceTrack there = track.in(other);
  const BodyMounting body{from_euler({0.03, -0.04, 1.2}), {0.06, 0.05, -0.03}};
  for (double t = track.span().start + 0.01; t < track.span().end; t += 0.2) {
    const ReferenceTrack::State a = track.at(t, body), b = there.at(t, body);
    const Geodetic place = p.plate.world().to_geodetic(a.p_wb), same = other.to_geodetic(b.p_wb);
    EXPECT_NEAR(place.latitude, same.latitude, 1e-14);
    EXPECT_NEAR(place.longitude, same.longitude, 1e-14);
    EXPECT_NEAR(place.height, same.height, 1e-7);
    const Matrix3d R_nw = p.plate.world().rotation_wn(a.p_wb).transpose(), R_nv = other.rotation_wn(b.p_wb).transpose();
    EXPECT_LT((R_nw * a.v_wb - R_nv * b.v_wb).norm(), 1e-9);
    EXPECT_LT((R_nw * a.q_wb.toRotationMatrix() - R_nv * b.q_wb.toRotationMatrix()).norm(), 1e-9);
    EXPECT_GT((a.p_wb - b.p_wb).norm(), 700);
  }
}

TEST(ReferenceTrack, EndsWithItsRows) {
  const Perfect p = perfect(short_slalom());
  const double start = p.imu.front().time;
  const ReferenceTrack track(p.solution, p.imu, {start + 0.5, start + 1});
  EXPECT_GE(track.span().start, start + 0.5);
  EXPECT_LE(track.span().end, start + 1);
  EXPECT_TRUE(ReferenceTrack(p.solution, p.imu, {0, 1}).empty());
}

}  // namespace
}  // namespace piste
