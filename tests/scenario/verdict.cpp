// What is put into a simulated run is what its verdict names first, and clean runs have a verdict without findings.

#include "piste/consistency/verdict.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "piste/diagnosis/diagnose.h"
#include "piste/replay/replay.h"
#include "piste/sim/random.h"
#include "piste/sim/replay_setup.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

Verdict verdict_of(const Case& c, const Recording& recording) {
  const ReplayOptions options{.conditioning = c.conditioning, .filter = c.options};
  const Replay run = replay(recording, options);
  return diagnose(run.log, run.options, options.heading, run.found, run.filtered.solution, &*run.smoothed);
}

/// A cause: what is true and not told, or told and not true; and the words with which its finding begins.
struct Seeded {
  std::string motion, words;
  std::function<void(Scenario&)> truth = [](Scenario&) {};
  std::function<void(Case&, Recording&)> told = [](Case&, Recording&) {};
};

void scale_sigmas(Recording& recording, double position, double velocity) {
  for (GeodeticFix& fix : recording.gnss[0].fixes) {
    fix.sigma_position *= position;
    if (fix.velocity) fix.velocity->sigma *= velocity;
  }
}

std::vector<Seeded> seeded() {
  const auto gyro_noise = [](double by) { return [by](Case& c, Recording&) { c.options.sensor.gyro.noise /= by; }; };
  // 8 mg/sqrt(Hz), as of engines and roads.
  const auto shaken = [](Scenario& s) { s.imus[0].sensor.accel.noise *= 40; };
  const auto accel_noise = [](double by) { return [by](Case& c, Recording&) { c.options.sensor.accel.noise /= by; }; };
  const auto sigmas = [](double position, double velocity) {
    return [=](Case&, Recording& r) { scale_sigmas(r, position, velocity); };
  };
  const auto delay = [](double by) { return [by](Scenario& s) { s.gnss[0].delay = by; }; };
  const auto velocity_delay = [](double by) { return [by](Scenario& s) { s.gnss[0].velocity_delay = by; }; };
  const auto arm = [](const Vector3d& by) { return [by](Case& c, Recording&) { c.options.gnss[0].lever_arm += by; }; };
  const auto gyro_axes = [](const Matrix3d& axes) {
    return [axes](Case&, Recording& r) {
      for (Vector3d& w : r.imu.gyro) w = (axes * w).eval();
    };
  };
  const auto clock = [](double by) { return [by](Case& c, Recording&) { c.conditioning.imu.clock_drift += by; }; };
  const auto clock_off = [](double by) { return [by](Case& c, Recording&) { c.conditioning.imu.clock_offset += by; }; };
  const auto coloured = [](double sigma, double time) {
    return [=](Scenario& s) { s.gnss[0].position_drift = GaussMarkov{sigma * Vector3d(1, 1, 1.5), time}; };
  };
  // The sigmas that the receiver states are those of its white error alone.
  const auto white_sigmas = [](Case& c, Recording& r) {
    for (GeodeticFix& fix : r.gnss[0].fixes) fix.sigma_position = c.scenario.gnss[0].position_noise;
  };
  const auto none = [](Scenario&) {};
  const auto as_is = [](Case&, Recording&) {};
  Matrix3d swapped, turned;
  swapped << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  turned << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return {
      {"ski", "gyroscope noise", none, gyro_noise(10)},
      {"bicycle", "gyroscope noise", none, gyro_noise(10)},
      {"ski", "gyroscope noise", [](Scenario& s) { s.motion.rest_before = 300; }, gyro_noise(10)},  // of which a minute
      {"ski", "accelerometer noise", shaken, accel_noise(40)},
      {"giant_slalom", "accelerometer noise", shaken, accel_noise(10)},
      {"ski", "noise of gnss[0].position", none, sigmas(1. / 3, 1)},
      {"bicycle", "slow error of gnss[0].position", none, sigmas(4, 1)},  // as far as innovations can tell
      {"giant_slalom", "noise of gnss[0].velocity", none, sigmas(1, 1. / 3)},
      {"ski", "delay of the fixes", delay(0.1), as_is},
      {"giant_slalom", "delay of the fixes", delay(0.1), as_is},
      {"ski", "delay of the velocities", velocity_delay(0.3), as_is},
      {"bicycle", "delay of the velocities", velocity_delay(0.3), as_is},
      {"ski", "lever arm", none, arm({1.5, 0, 0})},
      {"bicycle", "lever arm", none, arm({0, -0.9, 1.2})},
      {"ski", "axes of the gyroscopes", none, gyro_axes(swapped)},
      {"bicycle", "axes of the gyroscopes", none, gyro_axes(turned)},
      {"ski", "gyroscope scale", [](Scenario& s) { s.imus[0].gyro.scale = Vector3d(0.05, 0.07, -0.06); }, as_is},
      {"giant_slalom", "accelerometer bias", [](Scenario& s) { s.imus[0].accel.bias = Vector3d(0.4, -0.5, 0.3); },
       as_is},
      {"bicycle", "clock drift", none, clock(1e-3)},
      {"ski", "clock drift", none, clock(-1e-3)},
      {"ski", "coloured error", coloured(1.5, 30), white_sigmas},
      {"bicycle", "coloured error", coloured(3, 60), white_sigmas},
      {"ski", "offset of the IMU's clock", none, clock_off(1)},
      {"bicycle", "offset of the IMU's clock", none, clock_off(-3)},
  };
}

/// A verdict with its numbers, to be read where a test fails.
std::string described(const Verdict& v) {
  std::string text = verdict_line(v) + '\n';
  for (const std::string& finding : v.findings) text += "    " + finding + '\n';
  for (const SourceVerdict& s : v.sources) {
    text +=
        fmt::format("    {}: nis {:.2f} ± {:.2f}, ratio {:.2f}, whiteness {:.2f}, rejected {:.3f}, smoothed {:.2f}\n",
                    s.name, s.nis, s.nis_error, s.ratio, s.whiteness, s.rejected, s.smoothed);
  }
  for (const PriorJump& jump : v.jumps) {
    if (std::abs(jump.sigmas) > 3) text += fmt::format("    {}: {:.1f} sigmas\n", jump.name, jump.sigmas);
  }
  return text;
}

TEST(Verdict, NamesWhatWasPutInFirst) {
  const std::vector<Seeded> all = seeded();
  std::size_t right = 0, tried = 0;
  for (std::size_t i = 0; i < all.size(); i += thorough() ? 1 : 7) {
    const Seeded& cause = all[i];
    Case c = make_case(cause.motion, 40, 100 + i, cause.truth);
    Recording recording = c.simulation.recording(0);
    cause.told(c, recording);
    const Verdict v = verdict_of(c, recording);
    const bool first = !v.consistent && !v.findings.empty() && v.findings.front().starts_with(cause.words);
    ++tried;
    right += first ? 1 : 0;
    fmt::print("{:5s} {:12s} {:26s} {}", first ? "" : "WRONG", cause.motion, cause.words,
               first ? verdict_line(v) + '\n' : described(v));
  }
  EXPECT_GE(20 * right, 19 * tried) << right << " of " << tried;
}

TEST(Verdict, HasNoFindingInCleanRuns) {
  const std::array<std::string, 4> motions{"ski", "bicycle", "easy_ski", "giant_slalom"};
  const int runs = seeds(4, 200);
  for (int seed = 1; seed <= runs; ++seed) {
    const std::string& motion = motions[static_cast<std::size_t>(seed) % motions.size()];
    const Case c = make_case(motion, 7. * seed, static_cast<std::uint64_t>(seed));
    const Verdict v = verdict_of(c, c.simulation.recording(0));
    EXPECT_TRUE(v.consistent && v.findings.empty()) << motion << " " << seed << ": " << described(v);
  }
}

// Fixes that differ by less than their white part: with a slow part stated there is nothing to find.
TEST(Verdict, HasNoFindingWhereASlowPartIsStated) {
  Case c = make_case("bicycle", 40, 6);
  Recording recording = c.simulation.recording(0);
  scale_sigmas(recording, 4, 1);
  EXPECT_FALSE(verdict_of(c, recording).consistent);
  c.options.gnss[0].drift = PositionDrift::of_share(Vector3d::Constant(0.9), 60);
  c.options.estimate = with_implied_blocks(c.options, c.options.estimate);
  const Verdict v = verdict_of(c, recording);
  EXPECT_TRUE(v.consistent && v.findings.empty()) << described(v);
  EXPECT_LT(v.sources.at(0).nis, 0.5);
}

// Outliers are left out, and the sigmas of what is used hold.
TEST(Verdict, HasNoFindingForOutliers) {
  for (const std::string motion : {"ski", "bicycle"}) {
    const Case c = make_case(motion, 40, 5);
    Recording recording = c.simulation.recording(0);
    RandomStream random(5, "outliers");
    for (std::size_t i = 1; i < recording.gnss[0].fixes.size(); ++i) {
      if (random.uniform() > 0.1) continue;
      recording.gnss[0].fixes[i].position.height += (2 + 98 * random.uniform()) * (random.uniform() < 0.5 ? -1 : 1);
    }
    const Verdict v = verdict_of(c, recording);
    EXPECT_TRUE(v.consistent && v.findings.empty()) << motion << ": " << described(v);
    EXPECT_NEAR(v.sources.at(0).rejected, 0.1, 0.04);
  }
}

// A receiver with a coloured error for which the filter is told of it, and a reference attitude.
TEST(Verdict, HasNoFindingWhereColouredErrorsAreTold) {
  for (int seed = 1; seed <= seeds(1, 20); ++seed) {
    Case c = make_case("bicycle", 40, static_cast<std::uint64_t>(seed), [](Scenario& s) {
      const Scenario all = read_scenario(s.file);
      s.gnss = {all.gnss[1]};
      s.attitude = all.attitude;
    });
    c.options.gnss[0].drift = c.scenario.gnss[0].position_drift;
    c.options.attitude[0].drift = c.scenario.attitude[0].drift;
    for (const Block block : {Block::kGnssPositionDrift, Block::kAttitudeDrift, Block::kBoresight})
      c.options.estimate.push_back(block);
    const Verdict v = verdict_of(c, c.simulation.recording(0));
    EXPECT_TRUE(v.consistent && v.findings.empty()) << seed << ": " << described(v);
  }
}

// The bicycle with barometer, two antennas and magnetometer, the filter told of all of them.
Case aided(std::uint64_t seed) {
  Case c = make_case("montecarlo/bicycle_aids", 40, seed);
  set_aids(c.options, c.scenario, c.scenario.imus[0]);
  c.options.estimate = with_implied_blocks(c.options, c.options.estimate);
  c.conditioning.magnetic = {.year = 2026, .interval = kMagneticInterval};
  return c;
}

TEST(Verdict, HasNoFindingInCleanRunsWithOtherSensors) {
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(seeds(1, 20)); ++seed) {
    const Case c = aided(seed);
    const Verdict v = verdict_of(c, c.simulation.recording(0));
    EXPECT_TRUE(v.consistent && v.findings.empty()) << seed << ": " << described(v);
  }
}

// What contradicts the receiver is the sensor beside it, which the search for a cause must not leave out.
TEST(Verdict, NamesASensorWhoseSigmasAreTooSmall) {
  Case c = aided(3);
  Recording recording = c.simulation.recording(0);
  for (HeadingFix& fix : recording.heading.fixes) fix.sigma /= 5;
  Verdict v = verdict_of(c, recording);
  ASSERT_FALSE(v.findings.empty()) << described(v);
  EXPECT_TRUE(v.findings[0].starts_with("noise of heading")) << described(v);
  recording = c.simulation.recording(0);
  for (HeightFix& fix : recording.height.fixes) fix.sigma /= 5;
  v = verdict_of(c, recording);
  ASSERT_FALSE(v.findings.empty()) << described(v);
  EXPECT_TRUE(v.findings[0].starts_with("noise of barometer")) << described(v);
}

TEST(Verdict, NamesABaselineThatPointsElsewhere) {
  for (const double off : {5., 90.}) {
    const Case c = aided(3);
    Recording recording = c.simulation.recording(0);
    for (HeadingFix& fix : recording.heading.fixes) fix.heading += off * kDegree;
    const Verdict v = verdict_of(c, recording);
    ASSERT_FALSE(v.findings.empty()) << off;
    EXPECT_TRUE(v.findings[0].starts_with("direction of `baseline`")) << off << ": " << described(v);
  }
}

// A lever arm or a noise makes up for a part of a wrong heading, and must not be named for it.
TEST(Verdict, NamesAnInitialHeadingThatTheMotionContradicts) {
  for (const double off : {20., 90.}) {
    const Case c = make_case("bicycle", 40, 3);
    const ReplayOptions by_motion{.conditioning = c.conditioning, .filter = c.options};
    const Replay clean = replay(c.simulation.recording(0), by_motion);
    ReplayOptions told = by_motion;
    const Estimate x = clean.smoothed->estimate(0);
    const Matrix3d R_nb = clean.log.world.rotation_wn(x.p_wb).transpose() * x.R_wb();
    told.heading = {InitialHeading::Source::kValue, to_euler(R_nb).z() + off * kDegree};
    const Replay run = replay(c.simulation.recording(0), told);
    const Verdict v = diagnose(run.log, run.options, told.heading, run.found, run.filtered.solution, &*run.smoothed);
    ASSERT_FALSE(v.findings.empty()) << off << ": " << described(v);
    EXPECT_TRUE(v.findings[0].starts_with("`initial: heading`")) << off << ": " << described(v);
  }
}

// A noise, or a bias that the filter may not change, makes up for what is not estimated.
TEST(Verdict, NamesAnEstimateWithoutBiases) {
  Case c = make_case("bicycle", 40, 3);
  EXPECT_TRUE(verdict_of(c, c.simulation.recording(0)).findings.empty());
  c.options.estimate.clear();
  const Verdict v = verdict_of(c, c.simulation.recording(0));
  ASSERT_FALSE(v.findings.empty());
  EXPECT_TRUE(v.findings[0].starts_with("`estimate` leaves out gyro_bias, accel_bias, ")) << described(v);
}

// In gauss, or without a field at all: the filter takes all of the Earth's field for iron.
TEST(Verdict, NamesAMagnetometerThatShowsNoField) {
  for (const double unit : {0.01, 0.}) {
    Case c = aided(3);
    c.options.magnetometer = MagnetometerOptions{};  // nobody knows what the iron is like
    Recording recording = c.simulation.recording(0);
    for (Vector3d& field : recording.imu.magnetic) field *= unit;
    const Verdict v = verdict_of(c, recording);
    ASSERT_FALSE(v.findings.empty()) << unit << ": " << described(v);
    EXPECT_TRUE(v.findings[0].starts_with("magnetometer")) << unit << ": " << described(v);
  }
}

}  // namespace
}  // namespace piste::test
