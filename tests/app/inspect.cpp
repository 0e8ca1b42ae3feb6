// The program `inspect` as its user meets it.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "piste/configuration/replay_config.h"
#include "piste/math/earth.h"
#include "report/well_formed.h"
#include "support/datasets.h"
#include "support/navigation.h"
#include "support/places.h"
#include "support/ski_run.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

const std::string kData = (kSource / "data/ski_run/").string();

struct InspectApp : ::testing::Test {
  TemporaryFolder folder;
  Said inspect(std::vector<std::string> words) const { return run_program(program("inspect"), words, folder); }
};

TEST_F(InspectApp, EndsWithAConfigurationThatReplays) {
  const Said said =
      inspect({kData + "mt9a_1.csv", kData + "gnss.csv", kData + "ln200_attitude.csv", "--output", "found"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "mt9a_1.csv: IMU"));
  EXPECT_TRUE(contains(said.out, "100 Hz"));
  EXPECT_TRUE(contains(said.out, "A configuration for replay"));
  EXPECT_TRUE(contains(said.out, read_text(folder / "found/replay.yaml")));
  EXPECT_FALSE(contains(said.out, "vehicle:"));  // a skier is none
  const Said replayed =
      run_program(program("replay"), {"found/replay.yaml", "--output", "replayed", "--quiet"}, folder);
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(replayed.err, "");
  const Accuracy a = accuracy(read_table(folder / "replayed/smoothed.csv"),
                              read_table(kSource / "data/ski_run/truth.csv"), {302480, 302580});
  EXPECT_GT(a.epochs, 1000u);
  EXPECT_LT(a.horizontal, 0.1) << text_of(a);
  EXPECT_LT(std::max(a.roll, a.pitch), 1) << text_of(a);

  const std::string page = read_text(folder / "found/inspection.html");
  EXPECT_TRUE(contains(page, "What looks wrong"));
  EXPECT_TRUE(contains(page, "Track"));
  EXPECT_TRUE(contains(page, "id=\"plan\""));
  EXPECT_TRUE(contains(page, "data-chart=\"log_1_rate\""));
  for (const char* wrong : {"src=\"http", "href=\"http", "url(", ":nan", ",nan"}) {  // no network
    EXPECT_EQ(page.find(wrong), std::string::npos) << wrong;
  }
}

// The logs of the run as another program may write them: rows out of order and twice, other names and units, gyroscopes
// and accelerometers apart, velocities upwards.
TEST_F(InspectApp, InputsAsTheyComeReplay) {
  const Table imu = read_table(kData + "mt9a_1.csv"), gnss = read_table(kData + "gnss.csv");
  constexpr double kStart = 302400;
  std::string gyro = "Sensor: A\nTimestampGyro [ms]; GyroX [rad/s]; GyroY [rad/s]; GyroZ [rad/s]\n",
              accel = "Sensor: B\nTimestampAcc [ms]; AccX [g]; AccY [g]; AccZ [g]\n",
              fixes = "seconds,Latitude,Longitude,Altitude (m),std_n (m),std_e (m),std_u (m),vn,ve,vu,sdvn,sdve,sdvu\n",
              places = "seconds,Latitude,Longitude,Altitude (m)\n";
  for (std::size_t i = 0; i < imu.rows; ++i) {
    const std::size_t row = i % 500 == 10 ? i + 1 : i % 500 == 11 ? i - 1 : i;  // two of each 500 are interchanged
    const double ms = 1e3 * (imu["time_s"][row] - kStart);
    for (int twice = 0; twice < (i % 700 == 50 ? 2 : 1); ++twice) {
      gyro += fmt::format("{:.3f};{:.8f};{:.8f};{:.8f};\n", ms, imu["gyro_x_rad_s"][row], imu["gyro_y_rad_s"][row],
                          imu["gyro_z_rad_s"][row]);
    }
    accel += fmt::format("{:.3f};{:.8f};{:.8f};{:.8f};\n", ms, imu["accel_x_m_s2"][row] / kStandardGravity,
                         imu["accel_y_m_s2"][row] / kStandardGravity, imu["accel_z_m_s2"][row] / kStandardGravity);
  }
  for (std::size_t i = 0; i < gnss.rows; ++i) {
    const std::string place = fmt::format("{:.3f},{:.9f},{:.9f},{:.4f}", gnss["time_s"][i] - kStart,
                                          gnss["latitude_deg"][i], gnss["longitude_deg"][i], gnss["height_m"][i]);
    places += place + "\n";
    fixes += fmt::format("{},0.01,0.01,0.02,{:.4f},{:.4f},{:.4f},0.025,0.025,0.04\n", place,
                         gnss["velocity_north_m_s"][i], gnss["velocity_east_m_s"][i], -gnss["velocity_down_m_s"][i]);
  }
  folder.write("gyro.txt", gyro);
  folder.write("accel.txt", accel);
  folder.write("fixes.csv", fixes);
  folder.write("places.csv", places);
  const Said said = inspect({"gyro.txt", "accel.txt", "fixes.csv", "--output", "found"});
  ASSERT_EQ(said.code, 0) << said.err;
  const std::string config = read_text(folder / "found/replay.yaml");
  EXPECT_TRUE(contains(config, "accel_file: '../accel.txt'"));
  EXPECT_TRUE(contains(config, "repair: true"));
  EXPECT_TRUE(contains(config, "velocity: {names: [vn, ve, vu], axes: north east up, unit: 'm/s'}"));
  const Said replayed =
      run_program(program("replay"), {"found/replay.yaml", "--output", "replayed", "--quiet"}, folder);
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const YAML::Node summary = YAML::LoadFile(folder / "replayed/summary.json");
  EXPECT_GT(summary["imu"]["repaired"]["sorted"].as<int>(), 20);
  EXPECT_GT(summary["imu"]["repaired"]["dropped"].as<int>(), 10);
  EXPECT_LE(summary["imu"]["unpaired"].as<int>(), 2);
  EXPECT_EQ(summary["gnss"]["repaired"]["sorted"].as<int>(), 0);
  Table truth = read_table(kSource / "data/ski_run/truth.csv");
  for (double& t : truth.columns.at("time_s")) t -= kStart;
  const Accuracy a = accuracy(read_table(folder / "replayed/smoothed.csv"), truth, {80, 180});
  EXPECT_GT(a.epochs, 1000u);
  EXPECT_LT(a.horizontal, 0.1) << text_of(a);
  if (!thorough()) return;
  ASSERT_EQ(inspect({"gyro.txt", "accel.txt", "places.csv", "--output", "without"}).code, 0);
  EXPECT_TRUE(contains(read_text(folder / "without/replay.yaml"), "sigma: 3 3 6 m"));
}

// The phone's times since power-up, of both sensors and of the receiver beside UTC, give the clock, but for the latency
// of what the receiver says: tenths of a second, as the motion tells.
TEST_F(InspectApp, APhonesThreeFiles) {
  PISTE_REQUIRE_DATASETS();
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1; scenario/no_hands inspects them, too";
  const std::string phone = (datasets() / "phone/20201104_091730_").string();
  const Said said = inspect({phone + "Acc.csv", phone + "Gyro.csv", phone + "GNSS.csv", "--output", "found"});
  ASSERT_EQ(said.code, 0) << said.err;
  const std::string config = read_text(folder / "found/replay.yaml");
  EXPECT_TRUE(contains(config, "Gyro.csv'\n  accel_file: ")) << config;
  EXPECT_TRUE(contains(config, "axes: -z +x -y")) << config;
  EXPECT_TRUE(contains(config, "# From the receiver's own two times")) << config;
  const ReplayConfig read = read_replay_config(folder / "found/replay.yaml");
  constexpr double kSaid = 184927.77;
  EXPECT_LT(read.conditioning.imu.clock_offset, kSaid + 0.03);
  EXPECT_GT(read.conditioning.imu.clock_offset, kSaid - 0.5);
  const Recording recording = read_recording(read);
  EXPECT_GT(recording.imu.time.size(), 49900u);
  EXPECT_LT(recording.imu.unpaired, 10u);
  EXPECT_EQ(recording.gnss.at(0).fixes.size(), 998u);
}

// The drive's velocities come late, and contradict its positions: what is said of them is accepted by a replay.
TEST_F(InspectApp, ItsAdviceIsAccepted) {
  PISTE_REQUIRE_DATASETS();
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1; inspect/ready_config has the words";
  const std::string drive = (datasets() / "drive/").string();
  const Said said = inspect({drive + "imu.txt", drive + "gnss_full.txt", "--output", "found"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "to use them all the same, `use: position velocity` and `velocity_delay: 0.128 s`"));
  std::string config = read_text(folder / "found/replay.yaml");
  const std::string use = "    use: position  ";
  ASSERT_TRUE(contains(config, use)) << config;
  config.replace(config.find(use), use.size(), "    use: position velocity\n    velocity_delay: 0.128 s\n    ");
  folder.write("found/advised.yaml", config + "span: {start: 243290 s, end: 243400 s}\n");
  const Said replayed =
      run_program(program("replay"), {"found/advised.yaml", "--output", "replayed", "--quiet"}, folder);
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_TRUE(contains(read_text(folder / "replayed/innovations.csv"), "velocity"));
}

// No header, and milliseconds since power-up in the last column.
TEST_F(InspectApp, ADrivesRawLogReplays) {
  PISTE_REQUIRE_DATASETS();
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const std::string drive = (datasets() / "drive/").string();
  ASSERT_EQ(inspect({drive + "imu_1934.csv", drive + "gnss_1934_sf.pos", "--output", "found", "--quiet"}).code, 0);
  const Said replayed =
      run_program(program("replay"), {"found/replay.yaml", "--output", "replayed", "--quiet"}, folder);
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const YAML::Node summary = YAML::LoadFile(folder / "replayed/summary.json");
  EXPECT_EQ(summary["imu"]["epochs"].as<int>(), 54860);
  EXPECT_TRUE(summary["sources"]["vehicle.right"]);  // proposed, as it is a car
  EXPECT_GT(summary["gnss"]["used"].as<int>(), 2100);
}

// Whatever it is at, Ctrl-C ends it at once, and nothing half written stays.
TEST_F(InspectApp, CtrlCEndsIt) {
  using namespace std::chrono_literals;
  const std::string name = program("inspect"), out = folder / "found";
  std::vector<std::string> words{name, kData + "mt9a_1.csv", kData + "gnss.csv", "--output", out, "--quiet"};
  for (const auto after : {30ms, 200ms, 700ms, 1500ms}) {
    std::vector<char*> argv;
    for (std::string& w : words) argv.push_back(w.data());
    argv.push_back(nullptr);
    pid_t child = 0;
    ASSERT_EQ(posix_spawn(&child, name.c_str(), nullptr, nullptr, argv.data(), environ), 0);
    std::this_thread::sleep_for(after);
    kill(child, SIGINT);
    const auto asked = std::chrono::steady_clock::now();
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) << "it was over after " << after.count() << " ms";
    EXPECT_LT(std::chrono::steady_clock::now() - asked, 1s);
    EXPECT_FALSE(std::filesystem::exists(out));
  }
}

// The bar shows what is being done, and goes on to the end.
TEST_F(InspectApp, ABarShowsAllOfTheWork) {
  if (std::system("script -qec true /dev/null >/dev/null 2>&1") != 0) GTEST_SKIP() << "`script` makes the terminal";
  const std::string command =
      fmt::format("{} {}mt9a_1.csv {}gnss.csv --output found", program("inspect"), kData, kData);
  const Said said = run_program("script", {"-qec", command, "shown"}, folder);
  ASSERT_EQ(said.code, 0) << said.out;
  const std::string shown = read_text(folder / "shown");
  for (const char* stage : {"clock and lever arm", "noise in motion", "whole log"}) {
    EXPECT_TRUE(contains(shown, stage)) << stage;
  }
  static const std::regex bar(R"((\d+) %  (\d+) s left)");
  std::vector<int> parts;
  for (std::sregex_iterator i(shown.begin(), shown.end(), bar), end; i != end; ++i) parts.push_back(std::stoi((*i)[1]));
  ASSERT_GT(parts.size(), 10u);
  EXPECT_TRUE(std::ranges::is_sorted(parts));
  EXPECT_GT(parts.back(), 85);
}

// Nine decimals of 105 degrees west are no latitude: the finding asks whether the columns are exchanged.
TEST_F(InspectApp, LatitudesBeyondNinetyDegrees) {
  std::string gnss = "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\n";
  for (int i = 0; i < 100; ++i) gnss += fmt::format("{},-105.1474,{:.7f},1600,1,1,2\n", i, 40.09 + 1e-5 * i);
  folder.write("gnss.csv", gnss);
  const Said said = inspect({"gnss.csv", kData + "mt9a_1.csv", "--output", "found"});
  EXPECT_TRUE(contains(said.out + said.err, "are latitude and longitude exchanged?")) << said.out << said.err;
}

TEST_F(InspectApp, SaysWhatItCannotRead) {
  folder.write("letter.txt", "Dear Sir,\nthe receiver that you sold me\n");
  folder.write("empty.csv", "");
  const Said letter = inspect({"letter.txt", kData + "gnss.csv", "--output", "found"});
  EXPECT_EQ(letter.code, 1);
  EXPECT_TRUE(contains(letter.err, "letter.txt:1: is none of the logs that piste reads; it begins with `Dear Sir,`"));
  EXPECT_TRUE(contains(letter.out, "gnss.csv: GNSS"));
  const Said empty = inspect({"empty.csv", "--output", "found"});
  EXPECT_EQ(empty.code, 1);
  EXPECT_TRUE(contains(empty.err, "empty.csv:1: the file is empty"));
  EXPECT_FALSE(std::filesystem::exists(folder / "found/replay.yaml"));
}

TEST_F(InspectApp, NamesAFaultWithItsLine) {
  const SkiRun run;
  run.edit_line(SkiRun::kImu, 1000,
                [](std::string& line) { line.replace(line.rfind(',') + 1, std::string::npos, "nan"); });
  const Said said = inspect({run.folder / SkiRun::kImu, run.folder / SkiRun::kGnss, "--output", "found"});
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "  1. "));
  EXPECT_TRUE(contains(said.out, "the first at 1000: field 7, `nan`"));
}

TEST_F(InspectApp, WrongUsage) {
  EXPECT_EQ(inspect({}).code, 2);
  const Said said = inspect({"nowhere.csv"});
  EXPECT_EQ(said.code, 2);
  EXPECT_TRUE(contains(said.err, "nowhere.csv: there is no such file"));
  EXPECT_EQ(inspect({"--help"}).code, 0);
}

}  // namespace
}  // namespace piste::test
