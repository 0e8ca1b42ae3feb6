// Runs of one course: the same gates, another line and speed for each seed.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "piste/core/error.h"
#include "piste/io/config.h"
#include "piste/math/units.h"
#include "piste/sim/scenario.h"
#include "piste/sim/simulation.h"
#include "support/places.h"

namespace piste::test {
namespace {

constexpr double kStart = 1000;

MotionOptions slalom(CourseOptions course) {
  MotionOptions motion;
  motion.rest_before = 5;
  motion.run = 60;
  motion.rest_after = 3;
  motion.speed = 15;
  motion.cycle = 4;
  motion.net_turn = 0.7;
  motion.sway_velocity.setZero();
  motion.vibration.setZero();
  motion.course = course;
  return motion;
}

Truth run_of(const MotionOptions& motion, std::uint64_t seed) {
  return Truth(World({46 * kDegree, 7 * kDegree, 2000}), motion, seed, kStart);
}

Vector3d direction_of(const CourseGate& gate) { return {std::cos(gate.heading), std::sin(gate.heading), 0}; }

// How far to the right of a gate a run passes it.
double offset_at(const Truth& run, const CourseGate& gate) {
  const double time = crossing_time(run, gate.place, direction_of(gate), run.start_time() + gate.about);
  const Vector3d right(-std::sin(gate.heading), std::cos(gate.heading), 0);
  return right.dot(run.at(time).p_wb - gate.place);
}

TEST(Course, GatesAreThoseOfAllRuns) {
  const MotionOptions motion = slalom({.gates = 12, .offset = 0.5, .speed = 0.03});
  const std::vector<CourseGate> gates = run_of(motion, 1).gates();
  ASSERT_EQ(gates.size(), 12u);
  EXPECT_EQ(gates_csv(run_of(motion, 1)), gates_csv(run_of(motion, 2)));
  EXPECT_NE(gates_csv(run_of(motion, 1)), gates_csv(run_of(slalom({.gates = 12, .seed = 2}), 1)));
  EXPECT_TRUE(run_of(slalom({}), 1).gates().size() == 2 && Truth(run_of({}, 1)).gates().empty());
  // A run without an own way passes through them, and at the speed of the course.
  const MotionOptions medium = slalom({.gates = 12});
  const Truth run = run_of(medium, 3);
  for (const CourseGate& gate : run.gates()) EXPECT_NEAR(offset_at(run, gate), 0, 1e-9);
  EXPECT_EQ(run.under_way().end - run.under_way().start, medium.run);
}

TEST(Course, LinesAndSpeedsAreTheRuns) {
  constexpr double kOffset = 0.5, kSpeed = 0.03;
  const MotionOptions motion = slalom({.gates = 12, .offset = kOffset, .speed = kSpeed});
  double square_offset = 0, square_speed = 0, apart = 0;
  constexpr int kRuns = 60;
  const double ramps = (motion.start_time + motion.stop_time) / 2;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const Truth run = run_of(motion, static_cast<std::uint64_t>(seed));
    const std::vector<CourseGate> gates = run.gates();
    for (const CourseGate& gate : gates) square_offset += square(offset_at(run, gate)) / (kRuns * 12.0);
    const double length = run.under_way().end - run.under_way().start;
    square_speed += square((motion.run - ramps) / (length - ramps) - 1) / kRuns;
    EXPECT_DOUBLE_EQ(run.end_time(), kStart + motion.rest_before + length + motion.rest_after);
    // All stop at the end of the course, beside one another.
    const Vector3d end = run.at(run.end_time()).p_wb, medium = run_of(slalom({}), 1).at(kStart + 68).p_wb;
    apart = std::max(apart, (end - medium).norm());
  }
  EXPECT_NEAR(std::sqrt(square_offset), kOffset, 0.1 * kOffset);
  EXPECT_NEAR(std::sqrt(square_speed), kSpeed, 0.2 * kSpeed);  // two standard errors of 60 runs
  EXPECT_GT(apart, kOffset);
  EXPECT_LT(apart, 5 * kOffset);
}

TEST(Course, DerivativesAgreeWithDifferences) {
  const Truth run = run_of(slalom({.offset = 0.5, .speed = 0.03}), 4);
  const auto difference = [](const auto& f, double t) {
    constexpr double kStep = 1e-3;
    return Vector3d((f(t - 2 * kStep) - 8 * f(t - kStep) + 8 * f(t + kStep) - f(t + 2 * kStep)) / (12 * kStep));
  };
  for (const double t : {kStart + 7.0, kStart + 20.0, kStart + 41.5, kStart + 63.0}) {
    const TruthState s = run.at(t);
    EXPECT_LT((difference([&](double x) { return run.at(x).p_wb; }, t) - s.v_wb).norm(), 1e-7) << t;
    EXPECT_LT((difference([&](double x) { return run.at(x).v_wb; }, t) - s.acceleration).norm(), 1e-6) << t;
  }
}

TEST(Course, CrossingTimesAreOfTheBody) {
  const Truth run = run_of(slalom({.gates = 5, .offset = 0.5, .speed = 0.03}), 2);
  const Truth body = run.attached(from_euler({0.1, -0.7, 0.2}), {0.1, -0.2, 0.3});
  for (const CourseGate& gate : body.gates()) {
    const Vector3d d = direction_of(gate);
    const double time = crossing_time(body, gate.place, d, kStart + gate.about);
    EXPECT_NEAR(d.dot(body.at(time).p_wb - gate.place), 0, 1e-8);
    EXPECT_LT(d.dot(body.at(time - 0.1).p_wb - gate.place), 0);
    EXPECT_GT(std::abs(time - crossing_time(run, gate.place, d, kStart + gate.about)), 1e-4);
    EXPECT_THROW(crossing_time(body, gate.place, -d, kStart + gate.about), DataError);
  }
}

TEST(Course, KeysAreChecked) {
  const auto read = [](const std::string& keys) {
    return read_scenario(
        Config::parse("origin: {latitude: 46 deg, longitude: 7 deg, height: 2000 m}\nmotion: {}\n"
                      "course: {" +
                          keys + "}\nimus: {name: a, sensor: " + source_folder() + "/config/sensors/xsens_mt9a.yaml}\n",
                      "s.yaml"));
  };
  const Scenario s = read("gates: 7, offset: 40 cm, speed: 2 %, seed: 9");
  ASSERT_TRUE(s.motion.course.has_value());
  EXPECT_EQ(s.motion.course->gates, 7);
  EXPECT_NEAR(s.motion.course->offset, 0.4, 1e-12);
  EXPECT_NEAR(s.motion.course->speed, 0.02, 1e-12);
  EXPECT_EQ(s.motion.course->seed, 9u);
  for (const char* wrong : {"gates: 1", "gates: 1001", "speed: 11 %", "seed: -1", "offset: 0.4", "gate: 3"}) {
    try {
      read(wrong);
      ADD_FAILURE() << wrong;
    } catch (const ConfigError& e) {
      EXPECT_EQ(e.where(), "s.yaml:3") << wrong << ": " << e.what();
    }
  }
}

}  // namespace
}  // namespace piste::test
