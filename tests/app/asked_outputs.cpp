// What a replay writes besides its usual files: further columns, points, whole covariances, events.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <vector>

#include "math/projection.h"
#include "piste/evaluate/evaluation.h"
#include "piste/trajectory/trajectory.h"
#include "support/navigation.h"
#include "support/random.h"
#include "support/ski_run.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

constexpr const char* kAll =
    "\nweek: 2200\noutput:\n  time: utc\n  geoid: egm96\n  covariance: full\n  columns: [enu, ecef, utm, speed, "
    "acceleration, rates]\n  at:\n    zero: 0 0 0 m\n    antenna: -0.06 0.03 -0.42 m\n    camera: {lever_arm: 0.1 0 0 "
    "m, "
    "boresight: 0 0 90 deg}\n";

class AskedOutputs : public testing::Test {
 protected:
  void replay_with(const std::string& keys, int code = 0) {
    run_.write(SkiRun::kConfig, config_ + keys);
    said_ = run_.replay();
    ASSERT_EQ(said_.code, code) << said_.err;
  }
  Table table(const std::string& name) const { return read_table(run_.folder / ("result/" + name)); }
  std::string text(const std::string& name) const { return read_text(run_.folder / ("result/" + name)); }

  SkiRun run_;
  std::string config_ = run_.text(SkiRun::kConfig);
  Said said_;
};

TEST_F(AskedOutputs, AreThereAndAgree) {
  replay_with(kAll);
  const Table rows = table("smoothed.csv"), zero = table("smoothed_zero.csv"), camera = table("smoothed_camera.csv"),
              antenna = table("smoothed_antenna.csv"), covariance = table("covariance_smoothed.csv");
  ASSERT_EQ(zero.rows, rows.rows);
  ASSERT_EQ(covariance.rows, rows.rows);
  double turned = 0, apart = 0;
  for (std::size_t i = 0; i < rows.rows; ++i) {
    for (const char* same : {"time_s", "latitude_deg", "longitude_deg", "height_m", "velocity_north_m_s", "roll_deg",
                             "sigma_north_m", "sigma_velocity_down_m_s", "sigma_heading_deg"}) {
      EXPECT_NEAR(zero[same][i], rows[same][i], 1.01e-5) << same << " in row " << i;
    }
    EXPECT_NEAR(std::sqrt(covariance["covariance_north_m_north_m"][i]), rows["sigma_north_m"][i], 1e-5);
    EXPECT_NEAR(std::sqrt(covariance["covariance_heading_deg_heading_deg"][i]), rows["sigma_heading_deg"][i], 1e-6);
    EXPECT_NEAR(rows["speed_m_s"][i], std::hypot(rows["velocity_north_m_s"][i], rows["velocity_east_m_s"][i]), 2e-5);
    const auto attitude = [&](const Table& of) {
      return from_euler(kDegree * Vector3d(of["roll_deg"][i], of["pitch_deg"][i], of["heading_deg"][i]));
    };
    turned = std::max(turned, attitude(camera).angularDistance(attitude(rows) * from_euler({0, 0, 90 * kDegree})));
    const World world({kDegree * rows["latitude_deg"][i], kDegree * rows["longitude_deg"][i], rows["height_m"][i]});
    const Vector3d arm = world.from_geodetic(
        {kDegree * antenna["latitude_deg"][i], kDegree * antenna["longitude_deg"][i], antenna["height_m"][i]});
    apart = std::max(apart, (arm - attitude(rows) * Vector3d(-0.06, 0.03, -0.42)).norm());
  }
  EXPECT_LT(turned, 1e-7);
  EXPECT_LT(apart, 3e-5);
  const double undulation = rows["height_m"][0] - rows["height_sea_m"][0];
  EXPECT_GT(undulation, 40);
  EXPECT_LT(undulation, 60);
  // At rest the force is that of gravity, and nothing accelerates.
  EXPECT_NEAR(std::hypot(std::hypot(rows["force_x_m_s2"][100], rows["force_y_m_s2"][100]), rows["force_z_m_s2"][100]),
              9.81, 0.1);
  EXPECT_NEAR(rows["acceleration_down_m_s2"][100], 0, 0.2);
  const std::string first = text("smoothed.csv");
  EXPECT_NE(first.find(",time_utc\n"), std::string::npos);
  EXPECT_NE(first.find("Z\n302"), std::string::npos);
  EXPECT_EQ(YAML::Load(text("summary.json"))["gps_week"].as<int>(), 2200);
  const std::string map = text("trajectory.kml");
  EXPECT_NE(map.find("<gx:Track>"), std::string::npos);
  EXPECT_NE(map.find("<when>2022-03-09T"), std::string::npos);
  // The errors of the filter in units of the smoother's covariance are no small ones, but finite.
  const Evaluation found = evaluate(read_trajectory({.path = run_.folder / "result"}),
                                    read_trajectory({.path = run_.folder / "result/filtered.csv"}));
  ASSERT_TRUE(found.nees.has_value());
  EXPECT_TRUE(std::isfinite(*found.nees));
  EXPECT_LT(evaluate(read_trajectory({.path = run_.folder / "result", .at = "antenna"}),
                     read_trajectory({.path = run_.folder / "result/smoothed_antenna.csv"}))
                .ape.max,
            1e-9);
}

TEST_F(AskedOutputs, NothingElseChanges) {
  replay_with("");
  const std::string rows = text("smoothed.csv"), filtered = text("filtered.csv"), biases = text("biases_smoothed.csv");
  EXPECT_EQ(text("summary.json").find("gps_week"), std::string::npos);
  EXPECT_EQ(text("trajectory.kml").find("gx:Track>"), std::string::npos);
  replay_with("\noutput: {at: {antenna: -0.06 0.03 -0.42 m}}\n");
  EXPECT_EQ(text("smoothed.csv"), rows);
  EXPECT_EQ(text("filtered.csv"), filtered);
  EXPECT_EQ(text("biases_smoothed.csv"), biases);
}

TEST_F(AskedOutputs, DatesNeedAWeek) {
  replay_with("\noutput: {time: gps_week}\n", 1);
  EXPECT_TRUE(contains(said_.err, "`week: 2374`")) << said_.err;
}

TEST_F(AskedOutputs, RefusesWrongKeys) {
  replay_with("\noutput: {columns: [epsg25832]}\n", 2);
  EXPECT_TRUE(contains(said_.err, "EPSG:2056")) << said_.err;
  replay_with("\noutput: {columns: [EPSG:99999999]}\n", 2);
  EXPECT_TRUE(contains(said_.err, "PROJ")) << said_.err;
  run_.write("marks.csv", "time_s\n302470\n");
  replay_with("\nevents: {file: ../marks.csv, text: word}\n", 2);
  EXPECT_TRUE(contains(said_.err, "`word` is none of: metashape, pix4d")) << said_.err;
  replay_with("\nevents: {file: ../marks.csv, delay: auto}\n", 1);
  EXPECT_TRUE(contains(said_.err, "marks.csv: `delay: auto` needs the places of at least 5 marks")) << said_.err;
}

TEST_F(AskedOutputs, PlacesOfAnyProjection) {
  if (!has_projections()) GTEST_SKIP() << "built without PROJ";
  replay_with("\noutput: {columns: [utm, EPSG:32632, epsg:2056], at: {antenna: -0.06 0.03 -0.42 m}}\n");
  for (const char* file : {"smoothed.csv", "smoothed_antenna.csv"}) {
    const Table rows = table(file);
    for (std::size_t i = 0; i < rows.rows; i += 100) {
      EXPECT_NEAR(rows["epsg_32632_easting_m"][i], rows["utm_easting_m"][i], 2e-5) << file;
      EXPECT_NEAR(rows["epsg_32632_northing_m"][i], rows["utm_northing_m"][i], 2e-5) << file;
      EXPECT_NEAR(rows["epsg_2056_easting_m"][i], 2.584e6, 2e3) << file;
    }
  }
}

TEST_F(AskedOutputs, RefusesEventsAtAnUnknownPoint) {
  run_.write("marks.csv", "time_s\n302470\n");
  replay_with("\nevents: [{file: ../marks.csv, at: camera}]\n", 2);
  EXPECT_TRUE(contains(said_.err, "`camera` is no point")) << said_.err;
}

// At epochs the states are those of smoothed.csv; between them they lie on the cubic of places and velocities.
TEST_F(AskedOutputs, EventsLieOnTheTrack) {
  std::mt19937 random(7);
  std::string marks = "name,time_s\n";
  constexpr int kCount = 2000;
  for (int i = 0; i < kCount; ++i) {
    const double t = 302440 + 54 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
    marks += fmt::format("shot {},{:.6f}\n", i, i % 10 == 0 ? std::round(100 * t) / 100 : t);
  }
  run_.write("marks.csv", marks);
  run_.write("late.csv", "time_s\n302470.117\n");
  replay_with(
      "\nevents: [{file: ../marks.csv}, {file: ../late.csv, delay: 0.017 s, offset: 0.1 s}, "
      "{file: ../late.csv, at: antenna}]\noutput: {at: {antenna: -0.06 0.03 -0.42 m}}\n");
  const std::string events = text("events.csv");
  EXPECT_EQ(events.substr(0, 25), "name,time_s,latitude_deg,");
  EXPECT_NE(events.find("\nmark_1,302470.034000,"), std::string::npos);
  run_.write("events.csv", events.substr(0, events.find("\nmark_1,") + 1));
  // In any order, as marks may be: sorted for a trajectory.
  Table table = read_table(run_.folder / "events.csv");
  ASSERT_EQ(table.rows, static_cast<std::size_t>(kCount));
  Trajectory track;
  track.file = "events.csv";
  std::vector<std::size_t> order(table.rows);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return table["time_s"][a] < table["time_s"][b]; });
  for (const std::size_t i : order) {
    if (!track.time.empty() && table["time_s"][i] <= track.time.back()) continue;
    track.time.push_back(table["time_s"][i]);
    track.place.push_back(
        {kDegree * table["latitude_deg"][i], kDegree * table["longitude_deg"][i], table["height_m"][i]});
    track.attitude.push_back(
        from_euler(kDegree * Vector3d(table["roll_deg"][i], table["pitch_deg"][i], table["heading_deg"][i])));
  }
  const Evaluation found = evaluate(track, read_trajectory({.path = run_.folder / "result"}));
  EXPECT_LT(found.ape.max, 1e-3);
  EXPECT_LT(found.ape_rotation->max, 0.01 * kDegree);
}

// An epoch is placed at an instant by a row there, with the rates of the sample that it divides: no signal changes.
TEST_F(AskedOutputs, EventsLieWhereEpochsPlacedThereDo) {
  run_.replace(SkiRun::kConfig, "  sampling: mean", "  stamps: as_logged\n  sampling: mean");
  const std::string whole = run_.text(SkiRun::kImu), config = run_.text(SkiRun::kConfig);
  const std::size_t head = whole.find('\n') + 1;
  std::vector<std::string> rows;
  std::istringstream lines(whole.substr(head));
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  const auto time_of = [&](std::size_t k) { return std::stod(rows[k]); };
  constexpr std::size_t kMany = 1500;  // fewer than a third of the rows: else whole intervals look like gaps
  constexpr double kSettled = SkiRun::kBegin + 10;  // every replay finds its own start, to millimetres
  std::vector<std::size_t> numbers;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (time_of(k - 1) > kSettled) numbers.push_back(k);
  }
  std::mt19937 random(11);
  std::size_t compared = 0;
  for (int part = 0; part < seeds(1, 7); ++part) {
    std::shuffle(numbers.begin(), numbers.end(), random);
    const std::set<std::size_t> divided(numbers.begin(), numbers.begin() + kMany);
    std::string placed = whole.substr(0, head), marks = "time_s\n";
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (divided.contains(k)) {
        const double share = 0.05 + 0.9 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
        const std::string time = fmt::format("{:.6f}", time_of(k - 1) + share * (time_of(k) - time_of(k - 1)));
        marks += time + "\n";
        placed += time + rows[k].substr(rows[k].find(',')) + "\n";
      }
      placed += rows[k] + "\n";
    }
    run_.write("marks.csv", marks);
    run_.write(SkiRun::kImu, whole);
    run_.write(SkiRun::kConfig, config + "\nevents: [{file: ../marks.csv}]\n");
    ASSERT_EQ(run_.replay().code, 0);
    const Table events = table("events.csv");
    run_.write(SkiRun::kImu, placed);
    run_.write(SkiRun::kConfig, config);
    ASSERT_EQ(run_.replay().code, 0);
    const Table epochs = table("smoothed.csv");
    std::map<double, std::size_t> row_at;
    for (std::size_t i = 0; i < epochs.rows; ++i) row_at[epochs["time_s"][i]] = i;
    const World world({kDegree * events["latitude_deg"][0], kDegree * events["longitude_deg"][0], 2480});
    const auto place = [&](const Table& of, std::size_t i) {
      return world.from_geodetic(
          {kDegree * of["latitude_deg"][i], kDegree * of["longitude_deg"][i], of["height_m"][i]});
    };
    const auto attitude = [](const Table& of, std::size_t i) {
      return from_euler(kDegree * Vector3d(of["roll_deg"][i], of["pitch_deg"][i], of["heading_deg"][i]));
    };
    ASSERT_EQ(events.rows, kMany);
    for (std::size_t i = 0; i < events.rows; ++i) {
      const auto at = row_at.find(events["time_s"][i]);
      ASSERT_NE(at, row_at.end()) << events["time_s"][i];
      EXPECT_LT((place(events, i) - place(epochs, at->second)).norm(), 1e-3) << events["time_s"][i];
      EXPECT_LT(attitude(events, i).angularDistance(attitude(epochs, at->second)), 0.01 * kDegree);
      ++compared;
    }
  }
  if (thorough()) {
    EXPECT_GE(compared, 10000u);
  }
}

// A shutter that opens 17 ms after its mark: at 7 m/s the place is 12 cm off without the key, and right with it.
TEST_F(AskedOutputs, AShutterDelayIsTwelveCentimetres) {
  std::string marks = "time_s\n", opened = "time_s\n";
  constexpr int kCount = 100;
  for (int i = 0; i < kCount; ++i) {
    const double mark = 302470 + 0.2 * i + 0.0031;
    marks += fmt::format("{:.6f}\n", mark);
    opened += fmt::format("{:.6f}\n", mark + 0.017);
  }
  run_.write("marks.csv", marks);
  run_.write("opened.csv", opened);
  replay_with("\nevents: [{file: ../marks.csv}, {file: ../marks.csv, delay: 0.017 s}, {file: ../opened.csv}]\n");
  const Table events = table("events.csv");
  ASSERT_EQ(events.rows, 3u * kCount);
  const World world({kDegree * events["latitude_deg"][0], kDegree * events["longitude_deg"][0], 2480});
  const auto place = [&](std::size_t i) {
    return world.from_geodetic(
        {kDegree * events["latitude_deg"][i], kDegree * events["longitude_deg"][i], events["height_m"][i]});
  };
  double worst = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::size_t opens = i + 2 * std::size_t{kCount};
    const Vector3d velocity(events["velocity_north_m_s"][opens], events["velocity_east_m_s"][opens],
                            events["velocity_down_m_s"][opens]);
    const double without = (place(i) - place(opens)).norm() * 7 / velocity.norm();
    EXPECT_NEAR(without, 0.12, 0.01) << i;
    worst = std::max(worst, (place(i + kCount) - place(opens)).norm());
  }
  EXPECT_LT(worst, 1e-6);
}

// Places of a camera, as a bundle adjustment has them, tell how late its shutter is: with noise, an offset of their own
// and one that is wrong altogether.
TEST_F(AskedOutputs, FindsTheDelayOfMarks) {
  std::string marks = "time_s\n";
  constexpr int kCount = 80;
  for (int i = 0; i < kCount; ++i) marks += fmt::format("{:.6f}\n", 302470.0137 + 0.25 * i);
  run_.write("marks.csv", marks);
  const std::string camera = "\noutput: {at: {camera: 0.4 0.1 -0.2 m}}\nevents: {at: camera, file: ../";
  replay_with(camera + "marks.csv, delay: 0.0831 s}\n");
  const Table truth = table("events.csv");
  EXPECT_FALSE(std::filesystem::exists(run_.folder / "result/events.json"));
  Random random(5);
  std::string placed = "name,time_s,latitude_deg,longitude_deg,height_m\n";
  for (std::size_t i = 0; i < kCount; ++i) {
    const World world({kDegree * truth["latitude_deg"][i], kDegree * truth["longitude_deg"][i], truth["height_m"][i]});
    const Vector3d error = Vector3d(0.5, -0.3, 1.1) + random.vector(i == 20 ? 30 : 0.02);
    const Geodetic place = world.to_geodetic(error);
    placed += fmt::format("p{},{:.6f},", i, 302470.0137 + 0.25 * static_cast<double>(i));
    placed += i % 10 == 3 ? ",,\n"
                          : fmt::format("{:.10f},{:.10f},{:.5f}\n", kDegreesPerRadian * place.latitude,
                                        kDegreesPerRadian * place.longitude, place.height);
  }
  run_.write("placed.csv", placed);
  replay_with(camera + "placed.csv, delay: auto, text: [metashape, pix4d]}\n");
  const YAML::Node found = YAML::Load(text("events.json"))[0];
  const double delay = found["delay_s"].as<double>(), sigma = found["sigma_delay_s"].as<double>();
  EXPECT_LT(std::abs(delay - 0.0831), 3 * sigma);
  EXPECT_LT(sigma, 1e-3);
  EXPECT_GT(sigma, 1e-4);
  EXPECT_EQ(found["marks"].as<int>(), kCount);
  EXPECT_EQ(found["used"].as<int>(), 71);
  EXPECT_NEAR(found["residual_m"].as<double>(), 0.02, 0.003);
  EXPECT_NEAR(found["offset_m"][2].as<double>(), 1.1, 0.02);
  const Table events = table("events.csv");
  for (std::size_t i = 0; i < kCount; i += 9)
    EXPECT_NEAR(events["time_s"][i], truth["time_s"][i] + delay - 0.0831, 2e-6);
  for (const char* name : {"events_metashape.txt", "events_pix4d.txt"}) {
    const std::string rows = text(name);
    EXPECT_EQ(std::ranges::count(rows, '\n'), kCount + 1) << name;
    EXPECT_NE(rows.find("\np79,"), std::string::npos) << name;
  }
  run_.write("placed.csv", std::regex_replace(placed, std::regex("3024"), "3014"));
  replay_with(camera + "placed.csv, delay: auto}\n", 1);
  EXPECT_TRUE(contains(said_.err, "lies outside the run while its delay is sought")) << said_.err;
}

TEST_F(AskedOutputs, RefusesMarksOutsideTheRun) {
  run_.write("marks.csv", "time_s\n302970\n");
  replay_with("\nevents: [{file: ../marks.csv}]\n", 1);
  EXPECT_TRUE(contains(said_.err, "marks.csv: an instant at 302970.000000 s lies outside the run")) << said_.err;
}

}  // namespace
}  // namespace piste::test
