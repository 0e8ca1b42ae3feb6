// Trajectories whose errors are known. evo_oracle.py holds the same against another program.

#include "piste/evaluate/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "piste/core/error.h"
#include "piste/math/units.h"

namespace piste {
namespace {

const Geodetic kPlace{46.5 * kDegree, 7.5 * kDegree, 2000};

// A curve with its velocity, on the Earth: north, east, down of kPlace are x, y, z.
Vector3d curve(double t) { return {30 * std::sin(0.2 * t), 8 * t, 0.5 * std::cos(0.3 * t)}; }
Vector3d curve_velocity(double t) { return {6 * std::cos(0.2 * t), 8, -0.15 * std::sin(0.3 * t)}; }

Trajectory on_earth(double first, double last, double step, const Vector3d& off = Vector3d::Zero(), double late = 0) {
  const World world(kPlace);
  Trajectory track;
  track.file = "track.csv";
  for (double t = first; t <= last + 1e-9; t += step) {
    const Vector3d p = curve(t - late) + off;
    const Matrix3d R_nw = world.rotation_wn(p).transpose();
    track.time.push_back(t);
    track.place.push_back(world.to_geodetic(p));
    track.velocity.emplace_back(R_nw * curve_velocity(t - late));
    track.attitude.push_back(from_euler({0.1, -0.05, 0.3 + 0.01 * t}));
    track.sigma_position.emplace_back(0.1, 0.1, 0.2);
  }
  return track;
}

Trajectory in_own_axes(const std::vector<Vector3d>& points, double step = 1) {
  Trajectory track;
  track.geodetic = false;
  for (const Vector3d& p : points) {
    track.time.push_back(step * static_cast<double>(track.time.size()));
    track.position.push_back(p);
  }
  return track;
}

std::vector<Vector3d> some_points() { return {{0, 0, 0}, {10, 1, 0}, {12, 8, 3}, {4, 9, -2}, {-3, 2, 5}}; }

TEST(AlignPoints, FindsTheMotionThatTheKindAllows) {
  const std::vector<Vector3d> a = some_points();
  const Matrix3d tilted = so3_exp({0.3, -0.2, 0.9}).toRotationMatrix(),
                 turned = so3_exp({0, 0, 0.9}).toRotationMatrix();
  const Vector3d t(3, -4, 5);
  const auto moved = [&](double s, const Matrix3d& R) {
    std::vector<Vector3d> b;
    for (const Vector3d& p : a) b.emplace_back(s * R * p + t);
    return b;
  };
  const Similarity position = align_points(a, moved(1, Matrix3d::Identity()), AlignmentKind::kPosition),
                   yaw = align_points(a, moved(1, turned), AlignmentKind::kYaw),
                   se3 = align_points(a, moved(1, tilted), AlignmentKind::kSe3),
                   sim3 = align_points(a, moved(1.5, tilted), AlignmentKind::kSim3),
                   none = align_points(a, moved(1.5, tilted), AlignmentKind::kNone);
  EXPECT_TRUE(position.translation.isApprox(t, 1e-12));
  EXPECT_TRUE(yaw.rotation.isApprox(turned, 1e-12));
  EXPECT_TRUE(se3.rotation.isApprox(tilted, 1e-12));
  EXPECT_TRUE(sim3.rotation.isApprox(tilted, 1e-12));
  EXPECT_NEAR(sim3.scale, 1.5, 1e-12);
  EXPECT_TRUE(sim3.translation.isApprox(t, 1e-12));
  EXPECT_TRUE(none.rotation.isIdentity() && none.translation.isZero() && none.scale == 1);
}

// A mirror image is no rotation.
TEST(AlignPoints, IsARotation) {
  std::vector<Vector3d> b;
  for (const Vector3d& p : some_points()) b.emplace_back(p.x(), p.y(), -p.z());
  EXPECT_NEAR(align_points(some_points(), b, AlignmentKind::kSe3).rotation.determinant(), 1, 1e-12);
}

TEST(AlignPoints, RefusesWhatDeterminesNoRotation) {
  const std::vector<Vector3d> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  EXPECT_THROW(align_points(line, line, AlignmentKind::kSe3), DataError);
  EXPECT_THROW(align_points({{0, 0, 0}}, {{0, 0, 0}}, AlignmentKind::kYaw), DataError);
}

TEST(ErrorStatistics, AreThoseOfNumbersByHand) {
  const ErrorStatistics s = error_statistics({4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(s.min, 1);
  EXPECT_DOUBLE_EQ(s.max, 4);
}

TEST(RelativeStep, ReadsLengthsAndTimes) {
  EXPECT_TRUE(relative_step("100m").is_distance);
  EXPECT_DOUBLE_EQ(relative_step("0.5 km").length, 500);
  EXPECT_FALSE(relative_step("1 s").is_distance);
  EXPECT_EQ(relative_step("100m").name(), "100 m");
  for (const char* wrong : {"", "m", "100", "-3 m", "0 s", "2 kg"}) EXPECT_THROW(relative_step(wrong), ConfigError);
}

TEST(Evaluate, FindsAConstantErrorAndItsSigmas) {
  const Trajectory b = on_earth(0, 60, 0.1), a = on_earth(0, 60, 0.1, {0.15, 0, -0.1});
  const Evaluation found = evaluate(a, b);
  EXPECT_EQ(found.rows.size(), 601u);
  EXPECT_NEAR(found.ape.rmse, std::hypot(0.15, 0.1), 1e-6);
  EXPECT_NEAR(found.cep95, 0.15, 1e-6);
  EXPECT_NEAR(found.rows[300].error[0], 0.15, 1e-5);
  EXPECT_NEAR(found.rows[300].up, 0.1, 1e-4);
  EXPECT_EQ(found.within_sigma[0], (std::array<double, 3>{0, 1, 1}));  // 0.15 m of 0.1 m
  EXPECT_EQ(found.within_sigma[2], (std::array<double, 3>{1, 1, 1}));
  EXPECT_TRUE(std::isnan(found.within_sigma[3][0]));
  const Evaluation aligned = evaluate(a, b, {.align = AlignmentKind::kPosition});
  EXPECT_LT(aligned.ape.rmse, 1e-6);
}

// Along and right of the course, which is east at t = 2.5 π: north of it is to the left.
TEST(Evaluate, SplitsErrorsByTheCourse) {
  const Trajectory b = on_earth(0, 20, 0.01), a = on_earth(0, 20, 0.01, {0.2, 0.5, 0});
  const Evaluation found = evaluate(a, b);
  const auto row = static_cast<std::size_t>(std::lround(100 * 2.5 * 3.14159265));
  EXPECT_NEAR(found.rows[row].along, 0.5, 1e-3);
  EXPECT_NEAR(found.rows[row].across, -0.2, 1e-3);
}

TEST(Evaluate, InterpolatesTheDenserFileByItsVelocities) {
  const Evaluation found = evaluate(on_earth(0.05, 59, 1), on_earth(0, 60, 0.1));
  EXPECT_EQ(found.rows.size(), 59u);
  EXPECT_LT(found.ape.max, 1e-5);  // a line would be 3e-4 m off
  Trajectory without = on_earth(0, 60, 0.1);
  without.velocity.clear();
  EXPECT_GT(evaluate(on_earth(0.05, 59, 1), without).ape.max, 1e-4);
}

TEST(Evaluate, DoesNotInterpolateOverGaps) {
  Trajectory gap = on_earth(0, 60, 0.1);
  const auto cut = [](auto& rows) { rows.erase(rows.begin() + 200, rows.begin() + 230); };
  cut(gap.time);
  cut(gap.place);
  cut(gap.velocity);
  cut(gap.attitude);
  cut(gap.sigma_position);
  const Evaluation found = evaluate(on_earth(0.05, 59, 0.5), gap);
  EXPECT_EQ(found.in_gaps, 6u);
  EXPECT_LT(found.ape.max, 1e-5);
}

TEST(Evaluate, SaysBothSpansWithoutACommonTime) {
  try {
    evaluate(on_earth(0, 10, 1), on_earth(100, 110, 1));
    FAIL();
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find("0.000 to 10.000 s"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("100.000 to 110.000 s"), std::string::npos) << e.what();
  }
}

// A week later in one file alone.
TEST(Evaluate, BringsBothToOneWeek) {
  Trajectory later = on_earth(0, 60, 0.1);
  for (double& t : later.time) t += 604800;
  EXPECT_LT(evaluate(later, on_earth(0, 60, 0.1)).ape.max, 1e-6);
}

TEST(Evaluate, FindsATimeOffset) {
  EvaluationOptions options;
  options.find_offset = true;
  const Evaluation found = evaluate(on_earth(1, 59, 0.1, Vector3d::Zero(), 0.317), on_earth(0, 60, 0.1), options);
  EXPECT_NEAR(found.time_offset, -0.317, 1e-4);
  EXPECT_LT(found.ape.rmse, 2e-3);
}

// Steps of 10 m in 1 s: a pair of 25 m ends at the third row.
TEST(Evaluate, PairsFollowOneAnother) {
  std::vector<Vector3d> a, b;
  for (int i = 0; i < 10; ++i) {
    b.emplace_back(10 * i, 0, 0);
    a.emplace_back(10.1 * i, 0, 0);
  }
  EvaluationOptions options;
  options.steps = {{25, true}, {4, false}};
  const Evaluation found = evaluate(in_own_axes(a), in_own_axes(b), options);
  ASSERT_EQ(found.rpe.size(), 2u);
  EXPECT_EQ(found.rpe[0].pairs, 3u);
  EXPECT_NEAR(found.rpe[0].distance->max, 0.3, 1e-12);
  EXPECT_EQ(found.rpe[1].pairs, 2u);
  EXPECT_NEAR(found.rpe[1].distance->mean, 0.4, 1e-12);
  EXPECT_FALSE(found.rpe[0].rotation.has_value());
}

// Turned by a constant, an estimate has relative errors of its own axes none.
TEST(Evaluate, RelativeErrorsAreInTheBody) {
  Trajectory b = on_earth(0, 60, 0.1), a = b;
  a.geodetic = b.geodetic = false;
  const Quaterniond turn = so3_exp({0, 0, 0.7});
  for (std::size_t i = 0; i < b.size(); ++i) {
    b.position.push_back(curve(b.time[i]));
    a.position.emplace_back(turn * curve(b.time[i]));
    a.attitude[i] = turn * b.attitude[i];
  }
  const Evaluation found = evaluate(a, b);
  EXPECT_GT(found.ape.rmse, 10);
  EXPECT_LT(found.rpe[1].distance->max, 1e-12);
  EXPECT_NEAR(found.ape_rotation->max, 0.7, 1e-12);
}

}  // namespace
}  // namespace piste
