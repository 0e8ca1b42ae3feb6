// Laps of one log: found by themselves, and their gained times against the truth of a simulated ride.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "piste/core/error.h"
#include "piste/descents/descents.h"
#include "piste/io/config.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/outputs/folders.h"
#include "piste/sim/simulation.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

const World kWorld(Geodetic{46 * kDegree, 7 * kDegree, 500});
constexpr double kRadius = 60;

// Rides along a lemniscate of turns to both sides, the second lap by a tenth faster than the first, and so on.
Descent eights(double laps) {
  Descent run;
  run.name = "ride";
  double phase = -0.4, time = 100;
  constexpr double kInterval = 0.05;
  for (; phase < 2 * std::numbers::pi * laps; time += kInterval) {
    const double rate = 0.1 * (1 + 0.1 * std::floor(std::max(0.0, phase) / (2 * std::numbers::pi)));
    const Vector3d place(kRadius * std::sin(phase), kRadius * std::sin(2 * phase), 0),
        velocity = rate * kRadius * Vector3d(std::cos(phase), 2 * std::cos(2 * phase), 0);
    run.track.time.push_back(time);
    run.track.place.push_back(kWorld.to_geodetic(place));
    run.track.velocity.push_back(velocity);
    phase += kInterval * rate;
  }
  return run;
}

Gate gate_at(const std::string& name, double phase) {
  const Vector3d place(kRadius * std::sin(phase), kRadius * std::sin(2 * phase), 0);
  return {.name = name,
          .place = kWorld.to_geodetic(place),
          .heading = std::atan2(2 * std::cos(2 * phase), std::cos(phase))};
}

TEST(Laps, BeginAtTheFirstGateAndPassAll) {
  const std::vector<Gate> gates{gate_at("start", 0), gate_at("far", 2), gate_at("finish", 6)};
  const Descent run = eights(3.5);
  const std::vector<Descent> laps = laps_of(run, gates);
  ASSERT_EQ(laps.size(), 3u);  // the half one is left out
  EXPECT_EQ(laps[2].name, "ride_3");
  for (const Descent& lap : laps) EXPECT_EQ(lap.track.time.front(), run.track.time[lap.first_row]);
  const DescentReport report = compare_descents({run}, gates);
  EXPECT_EQ(report.runs, (std::vector<std::string>{"ride_1", "ride_2", "ride_3"}));
  for (std::size_t r = 0; r < 3; ++r) {
    const double rate = 0.1 * (1 + 0.1 * static_cast<double>(r));
    EXPECT_NEAR(report.sections[0].duration[r], 2 / rate, 0.02) << r;
    EXPECT_NEAR(report.sections[1].duration[r], 4 / rate, 0.02) << r;
    EXPECT_NEAR(report.gates[2].runs[r].gained, 60 - 6 / rate, 0.04) << r;
    EXPECT_EQ(report.gates[3].name, "lap");
    const double round = 2 * std::numbers::pi;
    EXPECT_NEAR(report.gates[3].runs[r].time - report.gates[0].runs[r].time, round / rate, 0.02) << r;
    EXPECT_NEAR(report.along.back().runs[r].gained, round / 0.1 - round / rate, 0.04) << r;
  }
}

TEST(Laps, AreFoundWithoutGates) {
  const std::vector<Descent> laps = laps_of(eights(3.5), {});
  ASSERT_GE(laps.size(), 3u);
  const double first = laps[1].track.time.front() - laps[0].track.time.front();
  EXPECT_NEAR(first, 20 * std::numbers::pi, 0.15 * first);
  EXPECT_LT(laps_of(eights(0.9), {}).size(), 2u);
  try {
    compare_descents({eights(0.9)}, {});
    ADD_FAILURE() << "one lap";
  } catch (const ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("`ride` does not pass its start three times"), std::string::npos) << e.what();
  }
}

// A ride of two laps and a bit, replayed: are gained times as sure as they say, and what would independence say?
TEST(Laps, GainedTimesTakeAllFourCrossings) {
  const TemporaryFolder folder;
  const Scenario scenario = read_scenario(Config::load(folder.write(
      "laps.yaml",
      fmt::format("base: {}/config/scenarios/ski_run.yaml\nattitude: []\nmotion: {{rest_before: 20 s, run: 100 s, "
                  "rest_after: 3 s, speed: 10 m/s, speed_swing: 1 m/s, net_turn: 800 deg, slope: 0 deg, "
                  "cycle: 6 s, turn: 30 deg, turn_variation: 0}}\n",
                  source_folder()))));
  const Simulation simulation = simulate(scenario, 3);
  OutputFolder output(folder.path());
  write_simulation(output, "", scenario, simulation, 3);
  output.commit();
  const std::string file = folder.write(
      "run.yaml", fmt::format("imu: {{file: mt9a_1.csv, sensor: {}/config/sensors/xsens_mt9a.yaml}}\n"
                              "gnss: {{file: gnss.csv, lever_arm: -0.06 0.03 -0.42 m}}\n"
                              "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale]\n",
                              source_folder()));
  const Descent ride = descent_of(read_replay_config(file), "");
  const std::vector<Descent> laps = laps_of(ride, {});
  ASSERT_EQ(laps.size(), 2u);
  const DescentReport report = compare_descents(laps, {});
  const Truth& body = simulation.bodies.front();
  const Geodetic& origin = laps.front().track.place.front();
  const auto ned = [](const Vector3d& enu) { return Vector3d(enu.y(), enu.x(), -enu.z()); };
  const World local(origin);
  const auto true_time = [&](const Passage& p, std::size_t r) {
    const Vector3d place = body.world().from_geodetic(local.to_geodetic(ned(p.place)));
    const Matrix3d turn = body.world().rotation_wn(place) * local.rotation_wn(ned(p.place)).transpose();
    return crossing_time(body, place, turn * ned(p.direction), p.runs[r].time);
  };
  const auto since = [&](const Passage& p, std::size_t r) { return true_time(p, r) - true_time(report.along[0], r); };
  double square_sum = 0, moved = 0;
  for (std::size_t i = 1; i < report.along.size(); ++i) {
    const Passage& p = report.along[i];
    const double truth = since(p, 0) - since(p, 1), sigma = p.runs[1].sigma_gained;
    ASSERT_GT(sigma, 0);
    EXPECT_LT(std::abs(p.runs[1].gained - truth), 5 * sigma) << p.distance;
    square_sum += square((p.runs[1].gained - truth) / sigma);
    moved = std::max(moved, std::abs(truth));
    EXPECT_LT(sigma, 2e-3);
  }
  EXPECT_GT(moved, 0.05);
  const double mean_square = square_sum / static_cast<double>(report.along.size() - 1);
  EXPECT_GT(mean_square, 0.3);
  EXPECT_LT(mean_square, 2.5);

  // A lap against itself gains nothing, and that is sure.
  Descent twin = laps[0];
  twin.name = "twin";
  const DescentReport same = compare_descents({laps[0], twin}, {});
  for (const Passage& gate : same.gates) EXPECT_LT(gate.runs[1].sigma_gained, 1e-6) << gate.name;
}

}  // namespace
}  // namespace piste::test
