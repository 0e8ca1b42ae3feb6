// The recorded drive: a car, MEMS-IMU and RTK, heading unknown at the start, GNSS withheld in windows. There is no
// independent truth: the fixes withheld are the reference, at the antenna.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "piste/configuration/replay_config.h"
#include "piste/io/log_io.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/places.h"
#include "support/program.h"
#include "support/thorough.h"
#include "support/withheld_fixes.h"

namespace piste::test {
namespace {

const Vector3d kLeverArm(0, -0.05, 0);

struct Sensor {
  std::string more = {};  // keys of the configuration
  std::string gyro_noise = "0.07 0.2 0.05 deg/s/sqrt(Hz)", accel_noise = "5 5 1.7 mg/sqrt(Hz)";  // as shipped
};

/// What filter and smoother made of the windows.
struct DriveErrors {
  WindowErrors filtered, smoothed;

  std::size_t windows() const { return filtered.end.size(); }
  double mean_end() const { return filtered.mean_end(); }
  double worst_inside() const { return smoothed.worst_inside(); }
  double within() const { return filtered.count.within(); }
  double along_within() const { return filtered.count.along_within(); }
};

DriveErrors replay_drive(const std::vector<Interval>& windows, const std::string& gnss, const Sensor& sensor = {}) {
  const TemporaryFolder folder;
  const std::string drive = (std::filesystem::absolute(datasets()) / "drive").string();
  std::string text = read_text(kSource / "config" / "sensors" / "mems_car.yaml");
  const auto set_noise = [&](const Sensor& as, std::string Sensor::*which) {
    const Sensor shipped;
    text.replace(text.find(shipped.*which), (shipped.*which).size(), as.*which);
  };
  set_noise(sensor, &Sensor::gyro_noise);
  set_noise(sensor, &Sensor::accel_noise);
  folder.write("sensor.yaml", text);
  std::string outages;
  for (const Interval& w : windows)
    outages += fmt::format("{}[{:.3f}, {:.3f}]", outages.empty() ? "" : ", ", w.start, w.end - w.start);
  folder.write("drive.yaml",
               fmt::format("imu: {{file: {0}/imu.txt, format: kf_gins, sensor: sensor.yaml}}\n"
                           "gnss: {{file: {0}/{1}, lever_arm: 0 -0.05 0 m}}\n"
                           "initial: {{heading: auto}}\n"
                           "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale]\n"
                           "outages: [{2}]\n{3}",
                           drive, gnss, outages, sensor.more));
  const Said said = run_program(program("replay"), {"drive.yaml", "--output", "result"}, folder);
  EXPECT_EQ(said.code, 0) << said.err;
  if (said.code != 0) return {};
  const GnssRecording fixes = read_gnss({drive + "/gnss.txt", LogFormat::kKfGins});
  const auto errors_of = [&](const char* solution) {
    return window_errors(read_table(folder / (std::string("result/") + solution)), fixes.fixes, windows, kLeverArm);
  };
  const DriveErrors errors{errors_of("filtered.csv"), errors_of("smoothed.csv")};
  for (std::size_t i = 0; i < windows.size(); ++i) {
    std::printf("window at %.1f s: filtered end %.2f m, smoothed worst %.2f m\n", windows[i].start,
                errors.filtered.end[i], errors.smoothed.worst[i]);
  }
  std::printf("mean end %.2f m, worst inside %.2f m; inside 3 sigma %.3f, along track %.3f\n", errors.mean_end(),
              errors.worst_inside(), errors.within(), errors.along_within());
  return errors;
}

const std::string kPositions = "gnss.txt, format: kf_gins, use: position";

TEST(Drive, WindowsOf15Seconds) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e = replay_drive(coast_windows(), kPositions);
  ASSERT_EQ(e.windows(), 10u);
  EXPECT_LE(e.mean_end(), 6.0);
  EXPECT_LE(e.worst_inside(), 0.6);
}

TEST(Drive, WindowsOf15SecondsWithOtherNoise) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e = replay_drive(coast_windows(), kPositions, {"", "0.05 deg/s/sqrt(Hz)", "3 mg/sqrt(Hz)"});
  ASSERT_EQ(e.windows(), 10u);
  EXPECT_LE(e.mean_end(), 6.0);
  EXPECT_LE(e.worst_inside(), 0.6);
}

// Placed 60, 200 and 400 s after the IMU's first sample. Other places cost up to 540 m on average: what 60 s without
// GNSS cost depends on the turns in them.
TEST(Drive, WindowsOf60Seconds) {
  PISTE_REQUIRE_DATASETS();
  std::vector<Interval> windows;
  for (const double start : {60, 200, 400}) windows.push_back({243261.729 + start, 243261.729 + start + 60});
  const DriveErrors e = replay_drive(windows, kPositions);
  ASSERT_EQ(e.windows(), 3u);
  EXPECT_LE(e.mean_end(), 300);
  EXPECT_LE(e.worst_inside(), 15);
}

// A car moves along its own axis.
const Sensor kCar{"vehicle: {kind: car}\n"};
void expect_in_car(const DriveErrors& e, std::size_t windows, double mean_end, double worst_inside) {
  ASSERT_EQ(e.windows(), windows);
  EXPECT_LE(e.mean_end(), mean_end);
  EXPECT_LE(e.worst_inside(), worst_inside);
  EXPECT_GE(e.within(), 0.95);
  EXPECT_GE(e.along_within(), 0.95);
}

const std::string kWithVelocities =
    "gnss_1934_sf.pos, format: rtklib_pos, use: position velocity, velocity_delay: 0.128 s";

TEST(Drive, WindowsOf15SecondsInACar) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e = replay_drive(coast_windows(), kWithVelocities, kCar);
  expect_in_car(e, 10, 3.0, 0.6);
}

std::vector<Interval> minutes() { return {{243400, 243460}, {243530, 243590}, {243660, 243720}}; }

// The batch is no worse than the smoother.
TEST(Drive, WindowsOf60SecondsInACar) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e = replay_drive(minutes(), kWithVelocities, kCar);
  expect_in_car(e, 3, 12.0, 5.0);

  Sensor by_batch = kCar;
  by_batch.more += "smoother: batch\n";
  const DriveErrors batch = replay_drive(minutes(), kWithVelocities, by_batch);
  ASSERT_EQ(batch.windows(), 3u);
  EXPECT_LE(batch.worst_inside(), 1.2 * e.worst_inside());
}

// A sensor file that does not know which axis the engine shakes: a twentieth of what it is without the vehicle.
TEST(Drive, WindowsOf60SecondsInACarWithTheSameNoiseOnAllAxes) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e =
      replay_drive(minutes(), kWithVelocities, {"vehicle: {kind: car}\n", "0.1 deg/s/sqrt(Hz)", "5 mg/sqrt(Hz)"});
  expect_in_car(e, 3, 16.0, 10.0);
}

TEST(Drive, RtklibPositionsAreThoseOfKfGins) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e = replay_drive(coast_windows(), "gnss_1934_sf.pos, format: rtklib_pos, use: position");
  ASSERT_EQ(e.windows(), 10u);
  EXPECT_LE(e.mean_end(), 6.0);
  EXPECT_LE(e.worst_inside(), 0.6);
}

// Its velocities come some 0.13 s late against its positions. Told so, a replay is no worse off with them than without.
TEST(Drive, LateVelocitiesAtTheirOwnTime) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e = replay_drive(
      coast_windows(), "gnss_1934_sf.pos, format: rtklib_pos, use: position velocity, velocity_delay: 0.128 s");
  ASSERT_EQ(e.windows(), 10u);
  EXPECT_LE(e.mean_end(), 6.0);
  EXPECT_LE(e.worst_inside(), 0.7);
}

// Not told, they are not to be believed, and to be survived.
TEST(Drive, SurvivesLateVelocities) {
  PISTE_REQUIRE_DATASETS();
  const DriveErrors e = replay_drive(coast_windows(), "gnss_1934_sf.pos, format: rtklib_pos, use: position velocity");
  ASSERT_EQ(e.windows(), 10u);
  EXPECT_LE(e.mean_end(), 25);
  EXPECT_LE(e.worst_inside(), 2);
}

// A figure of ten windows is one draw: the same windows at twenty places, each a step further on. The bounds leave room
// for another compiler.
struct Placements {
  const char* name;
  std::vector<Interval> (*windows)();
  double step;  // s
  std::string gnss;
  Sensor sensor;
  double mean_end, worst_inside;  // bounds of the means over the places [m]
};

class DrivePlacements : public ::testing::TestWithParam<Placements> {};

TEST_P(DrivePlacements, CostAsMuchOnAverage) {
  PISTE_REQUIRE_DATASETS();
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const Placements& p = GetParam();
  constexpr int kPlaces = 20;
  std::vector<double> ends, worst;
  for (int k = 0; k < kPlaces; ++k) {
    std::vector<Interval> windows = p.windows();
    for (Interval& w : windows) w = {w.start + k * p.step, w.end + k * p.step};
    const DriveErrors e = replay_drive(windows, p.gnss, p.sensor);
    ends.push_back(e.mean_end());
    worst.push_back(e.worst_inside());
  }
  const double end = mean(ends), inside = mean(worst);
  std::printf("%s, %d places: mean end %.2f m (standard deviation %.2f), worst smoothed %.2f m (%.2f)\n", p.name,
              kPlaces, end, standard_deviation(ends), inside, standard_deviation(worst));
  EXPECT_LT(end, p.mean_end);
  EXPECT_LT(inside, p.worst_inside);
}

std::vector<Interval> any_minutes() { return {{243305, 243365}, {243435, 243495}, {243565, 243625}}; }

INSTANTIATE_TEST_SUITE_P(
    Twenty, DrivePlacements,
    ::testing::Values(Placements{"FifteenSeconds", coast_windows, 2, kPositions, {}, 9, 1.5},
                      Placements{"FifteenSecondsWithVelocities", coast_windows, 2, kWithVelocities, {}, 9, 1.5},
                      Placements{"FifteenSecondsInACar", coast_windows, 2, kWithVelocities, kCar, 6, 1.5},
                      Placements{"Minutes", any_minutes, 6, kPositions, {}, 600, 40},
                      Placements{"MinutesInACar", any_minutes, 6, kWithVelocities, kCar, 25, 12}),
    [](const auto& each) { return each.param.name; });

// As `inspect` configures it, which proposes the vehicle: never worse than the same without it.
TEST(Drive, WindowsOf60SecondsAsInspected) {
  PISTE_REQUIRE_DATASETS();
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const TemporaryFolder folder;
  const std::string drive = (std::filesystem::absolute(datasets()) / "drive/").string();
  const Said found =
      run_program(program("inspect"), {drive + "imu.txt", drive + "gnss.txt", "--output", "found", "--quiet"}, folder);
  ASSERT_EQ(found.code, 0) << found.err;
  std::string outages;
  for (const Interval& w : minutes()) {
    outages += fmt::format("{}[{}, {}]", outages.empty() ? "" : ", ", w.start, w.end - w.start);
  }
  const std::string with = read_text(folder / "found/replay.yaml") + "outages: [" + outages + "]\n";
  std::string without = with;
  const std::string key = "vehicle: {kind: car, mounting: auto}\n";
  ASSERT_TRUE(contains(with, key));
  without.erase(without.find(key), key.size());
  const GnssRecording fixes = read_gnss({drive + "gnss.txt", LogFormat::kKfGins});
  const auto replay = [&](const std::string& text) {
    folder.write("found/outages.yaml", text);
    const Said said = run_program(program("replay"), {"found/outages.yaml", "--output", "result", "--quiet"}, folder);
    EXPECT_EQ(said.code, 0) << said.err;
  };
  const auto errors = [&](const char* rows) {
    return window_errors(read_table(folder / rows), fixes.fixes, minutes(), kLeverArm);
  };
  replay(without);
  const double body = errors("result/filtered.csv").mean_end();
  replay(with);
  const double car = errors("result/filtered.csv").mean_end(), smoothed = errors("result/smoothed.csv").worst_inside();
  std::printf("as inspected: %.1f m, smoothed %.1f m at worst, without the vehicle %.1f m\n", car, smoothed, body);
  EXPECT_LT(car, 8);
  EXPECT_LT(smoothed, 5);
  EXPECT_LT(car, body);
}

std::string phone_file(const char* of) {
  return (std::filesystem::absolute(datasets()) / "phone/20201104_091730_").string() + of + ".csv";
}

const std::string kPhoneNoise = "0.07 deg/s/sqrt(Hz)";  // as shipped

/// A replay of the phone's drive by hand.
std::string phone_config(const TemporaryFolder& folder, const std::string& gyro_noise) {
  const std::string& shipped = kPhoneNoise;
  std::string sensor = read_text(kSource / "config" / "sensors" / "phone_in_car.yaml");
  sensor.replace(sensor.find(shipped), shipped.size(), gyro_noise);
  folder.write("sensor.yaml", sensor);
  const std::string imu = fmt::format(
      "imu: {{file: {0}, accel_file: {1}, format: columns, axes: -z +x -y,\n"
      "  sensor: sensor.yaml, clock: {{offset: 184927.77 s}},\n"
      "  columns: {{time: {{name: TimestampGyro, of: boot}}, gyro: {{names: [GyroX, GyroY, GyroZ]}},\n"
      "    accel: {{names: [AccX, AccY, AccZ], time: {{name: TimestampAcc, of: boot}}}}}}}}\n",
      phone_file("Gyro"), phone_file("Acc"));
  const std::string gnss = fmt::format(
      "gnss: {{file: {0}, format: columns, sigma_velocity: 0.5 m/s, velocity_delay: 0.25 s,\n"
      "  columns: {{time: {{name: UTC time, of: utc}}, latitude: {{name: Lat}}, longitude: {{name: Lon}},\n"
      "    height: {{name: Height}}, horizontal_accuracy: {{name: Hor Acc}}, vertical_accuracy: {{name: Vert Acc}},\n"
      "    speed: {{name: Speed}}, course: {{name: Heading}}, speed_accuracy: {{name: Speed Acc}},\n"
      "    course_accuracy: {{name: Heading Acc}}}}}}\n",
      phone_file("GNSS"));
  return imu + gnss +
         "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale]\nsmoother: none\n"
         "vehicle: {kind: car}\n";
}

/// What windows of 60 s without GNSS cost a configuration; `name`: the file that it is written to.
WindowErrors phone_windows(const TemporaryFolder& folder, const std::string& name, const std::string& config,
                           const std::vector<double>& starts) {
  std::string outages;
  std::vector<Interval> windows;
  for (const double start : starts) {
    outages += fmt::format("{}[{}, 60]", outages.empty() ? "" : ", ", start);
    windows.push_back({start, start + 60});
  }
  folder.write(name, config + "outages: [" + outages + "]\n");
  const Said said = run_program(program("replay"), {name, "--output", "result", "--quiet"}, folder);
  EXPECT_EQ(said.code, 0) << said.err;
  const Recording logs = read_recording(read_replay_config(folder / name));
  return window_errors(read_table(folder / "result/filtered.csv"), logs.gnss[0].fixes, windows, kLeverArm);
}

// Another car, at up to 33 m/s, with the raw logs of a phone. Its windows of 60 s cost 305 m without the vehicle.
TEST(Drive, APhoneInACar) {
  PISTE_REQUIRE_DATASETS();
  const TemporaryFolder folder;
  const WindowErrors e =
      phone_windows(folder, "phone.yaml", phone_config(folder, kPhoneNoise), {289201, 289588, 289976});
  ASSERT_EQ(e.end.size(), 3U);
  std::printf("ends %.1f, %.1f and %.1f m, mean %.1f m; inside 3 sigma %.3f, along track %.3f\n", e.end[0], e.end[1],
              e.end[2], e.mean_end(), e.count.within(), e.count.along_within());
  EXPECT_LT(e.mean_end(), 60);
  EXPECT_GE(e.count.within(), 0.95);
  EXPECT_GE(e.count.along_within(), 0.95);
}

// Three windows are few: twelve of the whole drive, three to a replay, with several noises and as `inspect` has it.
TEST(Drive, APhoneInACarAllAlong) {
  PISTE_REQUIRE_DATASETS();
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const TemporaryFolder folder;
  const auto mean_end = [&](const std::string& name, const std::string& config) {
    double sum = 0;
    for (int turn = 0; turn < 4; ++turn) {
      std::vector<double> starts;
      for (int i = 0; i < 3; ++i) starts.push_back(289220 + 65 * turn + 260 * i);
      sum += phone_windows(folder, name, config, starts).mean_end() / 4;
    }
    return sum;
  };
  for (const char* noise : {"0.03", "0.07", "0.15"}) {
    const double mean = mean_end("phone.yaml", phone_config(folder, fmt::format("{} deg/s/sqrt(Hz)", noise)));
    std::printf("%s deg/s/sqrt(Hz): mean end %.0f m\n", noise, mean);
    EXPECT_LT(mean, 140);
  }
  const Said found =
      run_program(program("inspect"),
                  {phone_file("Acc"), phone_file("Gyro"), phone_file("GNSS"), "--output", "found", "--quiet"}, folder);
  ASSERT_EQ(found.code, 0) << found.err;
  const double inspected = mean_end("found/outages.yaml", read_text(folder / "found/replay.yaml"));
  std::printf("as inspected: mean end %.0f m\n", inspected);
  EXPECT_LT(inspected, 200);
}

}  // namespace
}  // namespace piste::test
