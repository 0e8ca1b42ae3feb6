// Odometer, barometer, two antennas and magnetometer of a scenario: their logs hold the truth and the errors that were
// added, and come back from their files as they were.

#include "piste/sim/aids.h"

#include <gtest/gtest.h>

#include "math/magnetic_field.h"
#include "piste/io/config.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "piste/sim/simulation.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

Scenario carried_by_a_car() {
  const std::string text = R"(
base: bicycle.yaml
motion: {rest_before: 5 s, run: 40 s, rest_after: 2 s, lean: 0}
imus:
  - name: body
    sensor: ../sensors/xsens_mt9a.yaml
    boresight: 10 -5 30 deg
    position: 0.5 0.2 -0.3 m
    magnetometer: {year: 2026, noise: 0.5 uT, hard_iron: 10 uT, soft_iron: 0.05,
                   disturbance: {sigma: 1 1 1 uT, correlation_time: 10 s}}
vehicle: {kind: car}
odometer: {rate: 20 Hz, noise: 0.05 m/s, scale: 0.02, slip: {sigma: 0.02 m/s, correlation_time: 5 s}}
barometer: {rate: 10 Hz, noise: 0.4 m, drift: {sigma: 20 m, correlation_time: 1000 s}}
heading: {rate: 5 Hz, noise: 0.3 deg, pitch_noise: 0.6 deg, baseline: 0 1 0 m}
)";
  return read_scenario(Config::parse(text, kSource / "config" / "scenarios" / "car.yaml"));
}

struct Spread {
  double squares = 0, count = 0;
  void add(double error, double sigma) {
    squares += error * error / (sigma * sigma);
    ++count;
  }
  // The mean square of the normalised error is one, within four of its sigmas.
  void expect_one(const char* what) const {
    EXPECT_GT(count, 100) << what;
    EXPECT_NEAR(squares / count, 1, 4 * std::sqrt(2 / count)) << what;
  }
};

TEST(Aids, HoldTheTruthAndTheErrorsThatWereAdded) {
  const Scenario s = carried_by_a_car();
  const Simulation run = simulate(s, 7);
  const SimulatedAids& aids = run.aids;
  const World& world = run.plate.world();
  EXPECT_NE(aids.odometer_scale, 0);
  Spread speed, height, heading, pitch, field;
  for (std::size_t k = 0; k < aids.speed.fixes.size(); ++k) {
    const SpeedFix& fix = aids.speed.fixes[k];
    const TruthState state = run.trunk.at(fix.time);
    const double forward = (state.q_wb.conjugate() * state.v_wb).x();
    speed.add(fix.speed - std::abs((1 + aids.odometer_scale) * (forward + aids.wheel_slip[k])), 0.05);
  }
  for (std::size_t k = 0; k < aids.height.fixes.size(); ++k) {
    const HeightFix& fix = aids.height.fixes[k];
    height.add(fix.height - world.to_geodetic(run.plate.at(fix.time).p_wb).height - aids.barometer_offset[k], 0.4);
  }
  for (const HeadingFix& fix : aids.heading.fixes) {
    const TruthState state = run.plate.at(fix.time);
    const Vector3d u = world.rotation_wn(state.p_wb).transpose() * (state.q_wb * Vector3d::UnitY());
    heading.add(std::remainder(fix.heading - std::atan2(u.y(), u.x()), 360 * kDegree), 0.3 * kDegree);
    pitch.add(fix.pitch.value() + std::asin(u.z()), 0.6 * kDegree);
  }
  const SimulatedImu& imu = run.imus[0];
  const Vector3d earth = magnetic_field(s.origin, 2026);
  for (std::size_t k = 0; k < imu.gps_time.size(); ++k) {
    const Vector3d b = field_in_body(run.bodies[0], imu.gps_time[k], earth);
    const Vector3d d = field_in_body(run.bodies[0], imu.gps_time[k], imu.magnetic_disturbance[k]);
    const Vector3d error = imu.recording.magnetic[k] - b - imu.soft_iron * b - d - imu.hard_iron;
    for (const double axis : error) field.add(axis, 0.5);
  }
  speed.expect_one("speed");
  height.expect_one("height");
  heading.expect_one("heading");
  pitch.expect_one("pitch");
  field.expect_one("field");
}

// The wheels of the simulated car roll along its axis: what the filter is told of mounting and contact point is true.
TEST(Aids, TheMountingIsTrue) {
  const Scenario s = carried_by_a_car();
  const Simulation run = simulate(s, 7);
  const TrueMounting mounting = true_mounting(s.q_tr, s.imus[0].q_rb, s.imus[0].p_rb_r);
  for (double t = run.plate.under_way().start + 5; t < run.plate.under_way().end - 5; t += 1) {
    const TruthState b = run.bodies[0].at(t), trunk = run.trunk.at(t);
    EXPECT_LT((b.q_wb * mounting.contact + b.p_wb - trunk.p_wb).norm(), 1e-9);
    EXPECT_LT(so3_log(trunk.q_wb * mounting.q_vb * b.q_wb.conjugate()).norm(), 1e-9);
  }
}

TEST(Aids, ComeBackFromTheirFiles) {
  const Simulation run = simulate(carried_by_a_car(), 7);
  const TemporaryFolder folder;
  const auto log = [&](const std::string& name, const std::string& text) {
    folder.write(name, text);
    return LogFile{.file = folder / name};
  };
  const auto speed = read_speed(log("speed.csv", speed_csv(run.aids.speed)), 1);
  const auto height = read_height(log("height.csv", height_csv(run.aids.height)), 1);
  const auto heading = read_heading(log("heading.csv", heading_csv(run.aids.heading)), 1);
  ASSERT_EQ(speed.fixes.size(), run.aids.speed.fixes.size());
  ASSERT_EQ(height.fixes.size(), run.aids.height.fixes.size());
  ASSERT_EQ(heading.fixes.size(), run.aids.heading.fixes.size());
  for (std::size_t k = 0; k < heading.fixes.size(); k += 7) {
    EXPECT_NEAR(speed.fixes[k].speed, run.aids.speed.fixes[k].speed, 1e-4);
    EXPECT_NEAR(height.fixes[k].height, run.aids.height.fixes[k].height, 1e-4);
    EXPECT_NEAR(heading.fixes[k].heading, run.aids.heading.fixes[k].heading, 1e-6);
    EXPECT_NEAR(heading.fixes[k].pitch.value(), run.aids.heading.fixes[k].pitch.value(), 1e-6);
    EXPECT_NEAR(heading.fixes[k].sigma_pitch, 0.6 * kDegree, 1e-6);
  }
}

}  // namespace
}  // namespace piste::test
