// `replay` as its user sees it: what it writes, says and returns.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <set>

#include "support/navigation.h"
#include "support/places.h"
#include "support/ski_run.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

const std::string kNavigation =
    "time_s,latitude_deg,longitude_deg,height_m,velocity_north_m_s,velocity_east_m_s,velocity_down_m_s,roll_deg,"
    "pitch_deg,heading_deg,sigma_north_m,sigma_east_m,sigma_down_m,sigma_velocity_north_m_s,sigma_velocity_east_m_s,"
    "sigma_velocity_down_m_s,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg";

/// Names of the files in a folder and below it, hidden ones too.
std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    names.insert(fs::relative(entry.path(), folder).string());
  }
  return names;
}

/// summary.json but for the two times that a run took, which must be there.
std::string timeless(const std::string& summary) {
  std::istringstream lines(summary);
  std::string line, kept;
  int times = 0;
  while (std::getline(lines, line)) {
    const bool time = line.find("\"cpu_s\"") != std::string::npos || line.find("\"wall_s\"") != std::string::npos;
    times += time ? 1 : 0;
    if (!time) kept += line + "\n";
  }
  EXPECT_EQ(times, 2);
  return kept;
}

TEST(Replay, ShippedRunGivesEveryOutput) {
  const TemporaryFolder folder;
  const Said said =
      run_program(program("replay"), {(kSource / "config/ski_run.yaml").string(), "--output", "result"}, folder);
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");  // no progress bar where it is redirected
  EXPECT_TRUE(contains(said.out, "heading"));
  EXPECT_TRUE(contains(said.out, "written to result"));
  EXPECT_EQ(
      names_in(folder.path() / "result"),
      (std::set<std::string>{"attitude.csv", "biases.csv", "biases_smoothed.csv", "filtered.csv", "innovations.csv",
                             "report.html", "smoothed.csv", "summary.json", "trajectory.kml"}));

  const Table imu = read_table(kSource / "data/ski_run/mt9a_1.csv");
  for (const char* name : {"filtered.csv", "smoothed.csv"}) {
    const Table navigation = read_table(folder / (std::string("result/") + name));
    EXPECT_EQ(navigation.header, kNavigation);
    EXPECT_EQ(navigation["time_s"], imu["time_s"]);  // one row an IMU epoch
    EXPECT_GE(*std::min_element(navigation["heading_deg"].begin(), navigation["heading_deg"].end()), -180);
    EXPECT_LE(*std::max_element(navigation["heading_deg"].begin(), navigation["heading_deg"].end()), 360);
  }

  std::set<std::string> columns{"time_s"};
  for (const char* kind : {"", "sigma_"}) {
    const auto add = [&](const std::string& name, const std::string& unit, const char* axes) {
      std::istringstream each(axes);
      for (std::string axis; each >> axis;) columns.insert(kind + name + "_" + axis + "_" + unit);
    };
    for (const char* name : {"gyro_bias", "gyro_drift", "gyro_total_bias"}) add(name, "deg_s", "x y z");
    for (const char* name : {"accel_bias", "accel_drift", "accel_total_bias"}) add(name, "m_s2", "x y z");
    for (const char* name : {"gyro_scale", "accel_scale"}) add(name, "ppm", "x y z");
    add("boresight", "deg", "roll pitch heading");
    add("attitude_drift", "deg", "north east down");
  }
  for (const char* name : {"biases.csv", "biases_smoothed.csv"}) {
    const Table biases = read_table(folder / (std::string("result/") + name));
    EXPECT_EQ(std::set<std::string>(biases.names.begin(), biases.names.end()), columns);
    const std::vector<double>&times = biases["time_s"], &all = imu["time_s"];  // ten a second, and epochs all
    EXPECT_NEAR(static_cast<double>(times.size()), 10 * (all.back() - all.front()), 3) << name;
    EXPECT_TRUE(std::includes(all.begin(), all.end(), times.begin(), times.end())) << name;
  }
  EXPECT_EQ(read_table(folder / "result/innovations.csv").header,
            "time_s,source,residual_1,residual_2,residual_3,sigma_1,sigma_2,sigma_3,nis,gate,outcome");
}

TEST(Replay, SaysWhichReceiverWasNotBelieved) {
  const SkiRun run;
  run.edit_rows(SkiRun::kGnss, [](std::vector<std::string>& row) {
    const double t = std::stod(row[0]);
    if (t >= 302475 && t < 302485) row[3] = fmt::format("{:.4f}", std::stod(row[3]) + 20);
  });
  const Said said = run.replay();
  ASSERT_EQ(said.code, 0);
  EXPECT_NE(said.err.find("gnss[0].position contradicted the rest, by 20 m at first: 100 fixes from 302475.000 s, over "
                          "9.9 s, were left out\n"),
            std::string::npos)
      << said.err;
  const YAML::Node counts = YAML::Load(run.text("result/summary.json"))["gnss"];
  EXPECT_GE(counts["rejected"].as<int>(), 100);
  EXPECT_EQ(counts["repeated"].as<int>(), 0);
}

TEST(Replay, SummaryHasTheContractedKeys) {
  const SkiRun run;
  ASSERT_EQ(run.replay().code, 0);
  const YAML::Node summary = YAML::Load(run.text("result/summary.json"));  // JSON is YAML
  const Table filtered = read_table(run.folder / "result/filtered.csv");
  EXPECT_EQ(summary["imu"]["epochs"].as<std::size_t>(), filtered.rows);
  EXPECT_EQ(summary["imu"]["gaps"].as<int>(), 0);
  EXPECT_EQ(summary["imu"]["rejected"].as<int>(), 0);
  for (const char* kind : {"gnss", "attitude"}) {  // 10 Hz over a minute: nothing is lost without a count
    const YAML::Node& counts = summary[kind];
    int all = 0;
    for (const char* key : {"used", "rejected", "withheld", "outside", "late"}) {
      if (counts[key]) all += counts[key].as<int>();
    }
    EXPECT_EQ(all, 601) << kind;
    EXPECT_LT(counts["rejected"].as<int>(), 6) << kind;
  }
  ASSERT_EQ(summary["rest_intervals"].size(), 1u);
  EXPECT_NEAR(summary["rest_intervals"][0][1].as<double>(), 302460, 1.5);

  const auto expect_estimate = [](const YAML::Node& estimate, const std::string& unit, const std::string& name) {
    ASSERT_TRUE(estimate) << name;
    EXPECT_EQ(estimate["unit"].as<std::string>(), unit) << name;
    ASSERT_EQ(estimate["value"].size(), 3u) << name;
    ASSERT_EQ(estimate["sigma"].size(), 3u) << name;
    for (int i = 0; i < 3; ++i) EXPECT_GT(estimate["sigma"][i].as<double>(), 0) << name;
  };
  const std::vector<std::pair<std::string, std::string>> blocks{
      {"gyro_bias", "deg/s"},   {"gyro_drift", "deg/s"}, {"gyro_scale", "ppm"}, {"accel_bias", "m/s^2"},
      {"accel_drift", "m/s^2"}, {"accel_scale", "ppm"},  {"boresight", "deg"}};
  for (const auto& [block, unit] : blocks) expect_estimate(summary["estimates"][block], unit, block);
  expect_estimate(summary["gyro_total_bias"], "deg/s", "gyro_total_bias");
  expect_estimate(summary["accel_total_bias"], "m/s^2", "accel_total_bias");
  EXPECT_TRUE(summary["verdict"]["consistent"].as<bool>());
  EXPECT_EQ(summary["verdict"]["findings"].size(), 0U);
  for (const char* source : {"gnss[0].position", "attitude[0]"}) {
    const YAML::Node verdict = summary["verdict"]["sources"][source];
    EXPECT_NEAR(verdict["nis"].as<double>(), 1, 0.3) << source;
    EXPECT_LT(verdict["rejected"].as<double>(), 0.02) << source;
  }
  EXPECT_GT(summary["cpu_s"].as<double>(), 0);
  EXPECT_GT(summary["wall_s"].as<double>(), 0);
}

// The attitude that a replay writes is one that a replay reads; the entry that it says is taken as it stands.
TEST(Replay, WritesAnAttitudeLogForAnotherReplay) {
  const SkiRun run;
  const Said said = run.replay({SkiRun::kConfig, "--output", "reference"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Table attitude = read_table(run.folder / "reference/attitude.csv"),
              smoothed = read_table(run.folder / "reference/smoothed.csv");
  EXPECT_EQ(attitude.header, "time_s,roll_deg,pitch_deg,heading_deg,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg");
  ASSERT_EQ(attitude.rows, 601U);  // 10 Hz of 60 s
  for (std::size_t i = 1; i < attitude.rows; ++i) {
    const double t = attitude["time_s"][i];
    ASSERT_NEAR(10 * t, std::round(10 * t), 1e-4);
    for (const std::string& name : attitude.names) {
      ASSERT_NEAR(std::remainder(attitude[name][i] - at(smoothed, name, t), 360.0), 0, 1e-6) << name << " at " << t;
    }
  }

  const YAML::Node error = YAML::Load(run.text("reference/summary.json"))["attitude_error"];
  const auto tau = error["correlation_time_s"].as<double>();
  EXPECT_GT(tau, 1);
  EXPECT_LE(tau, 60);
  double squares = 0;
  for (const double sigma : smoothed["sigma_heading_deg"]) squares += sigma * sigma;
  EXPECT_NEAR(error["sigma_deg"][2].as<double>(), std::sqrt(squares / static_cast<double>(smoothed.rows)), 1e-6);

  const auto entry = said.out.find("`attitude: {file: ");
  ASSERT_NE(entry, std::string::npos) << said.out;
  const std::string words = said.out.substr(entry + 1, said.out.find('`', entry + 1) - entry - 1);
  EXPECT_TRUE(contains(words, fmt::format("correlation_time: {:.1f} s", tau)));
  const auto again = [&](const std::string& heading) {
    run.write("config/again.yaml",
              "imu: {file: ../data/ski_run/mt9a_1.csv, sensor: sensors/xsens_mt9a.yaml}\n"
              "gnss: {file: ../data/ski_run/gnss.csv, lever_arm: -0.06 0.03 -0.42 m}\n" +
                  words + "\ninitial: {heading: " + heading +
                  "}\nestimate: [gyro_bias, accel_bias, gyro_drift, "
                  "accel_drift, gyro_scale, accel_scale, boresight]\n");
    const Said read = run.replay({"config/again.yaml", "--output", "again", "--quiet"});
    EXPECT_EQ(read.code, 0) << read.err;
    return YAML::Load(run.text("again/summary.json"));
  };
  for (const char* heading : {"auto", "from_attitude"}) {
    const YAML::Node summary = again(heading);
    EXPECT_GE(summary["attitude"]["used"].as<int>(), 590);
    const YAML::Node boresight = summary["estimates"]["boresight"];
    for (int i = 0; i < 3; ++i) {  // the same IMU on both sides
      const auto value = boresight["value"][i].as<double>();
      EXPECT_LT(std::abs(value), 0.3) << i;
      EXPECT_LT(std::abs(value), 4 * boresight["sigma"][i].as<double>()) << i;
    }
  }
}

TEST(Replay, TwiceTheSameBytes) {
  const SkiRun run;
  ASSERT_EQ(run.replay({SkiRun::kConfig, "--output", "first"}).code, 0);
  ASSERT_EQ(run.replay({SkiRun::kConfig, "--output", "second"}).code, 0);
  const auto names = names_in(run.folder / "first");
  EXPECT_EQ(names, names_in(run.folder / "second"));
  for (const std::string& name : names) {
    std::string first = run.text("first/" + name), second = run.text("second/" + name);
    if (name == "summary.json") {
      first = timeless(first);
      second = timeless(second);
    }
    EXPECT_TRUE(first == second) << name;
  }
}

TEST(Replay, WithoutSmoother) {
  const SkiRun run;
  run.replace(SkiRun::kConfig, "smoother: rts", "smoother: none");
  const Said said = run.replay({SkiRun::kConfig, "--output", "result"});
  ASSERT_EQ(said.code, 0);
  EXPECT_EQ(said.out.find("attitude:"), std::string::npos);  // how long a filter's error lasts is not known
  const Table attitude = read_table(run.folder / "result/attitude.csv"),
              filtered = read_table(run.folder / "result/filtered.csv");
  EXPECT_NEAR(attitude["heading_deg"].back(), at(filtered, "heading_deg", attitude["time_s"].back()), 1e-6);
  EXPECT_EQ(names_in(run.folder / "result"),
            (std::set<std::string>{"attitude.csv", "biases.csv", "filtered.csv", "innovations.csv", "report.html",
                                   "summary.json", "trajectory.kml"}));
}

TEST(Replay, SaysWhatItAdapted) {
  const SkiRun run;
  run.write(SkiRun::kConfig, run.text(SkiRun::kConfig) + "adapt: {within: 5}\n");
  const Said said = run.replay({SkiRun::kConfig, "--output", "result"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "adapted sigmas: gnss[0].position times")) << said.out;
  const YAML::Node adapted = YAML::Load(run.text("result/summary.json"))["adapted"];
  const Table rows = read_table(run.folder / "result/adapted.csv");
  EXPECT_EQ(rows.header, "time_s,gnss[0].position,gnss[0].velocity,attitude[0],gyro_noise,accel_noise");
  EXPECT_NEAR(static_cast<double>(rows.rows), 60, 2);
  for (const auto& entry : adapted) {
    const auto name = entry.first.as<std::string>();
    const YAML::Node range = entry.second;
    EXPECT_NEAR(range["last"].as<double>(), rows[name].back(), 1e-3) << name;
    EXPECT_LE(range["least"].as<double>(), range["mean"].as<double>()) << name;
    EXPECT_LE(range["mean"].as<double>(), range["most"].as<double>()) << name;
    EXPECT_LE(range["most"].as<double>(), 5) << name;
  }
  EXPECT_EQ(adapted.size(), 5U);
  EXPECT_TRUE(contains(run.text("result/report.html"), "Learned noise, over the stated"));

  run.replace(SkiRun::kConfig, "adapt: {within: 5}", "adapt: false");
  ASSERT_EQ(run.replay().code, 0);
  EXPECT_FALSE(fs::exists(run.folder / "result/adapted.csv"));
  EXPECT_FALSE(YAML::Load(run.text("result/summary.json"))["adapted"]);
}

TEST(Replay, RowsComeAtTheRatesThatAreAskedFor) {
  const SkiRun run;
  ASSERT_EQ(run.replay().code, 0);
  const Table whole = read_table(run.folder / "result/smoothed.csv"),
              few = read_table(run.folder / "result/biases.csv");
  run.write(SkiRun::kConfig, run.text(SkiRun::kConfig) + "output: {rate: 5 Hz, biases: imu}\n");
  ASSERT_EQ(run.replay().code, 0);
  const Table thinned = read_table(run.folder / "result/smoothed.csv"),
              all = read_table(run.folder / "result/biases.csv");
  EXPECT_EQ(all.rows, whole.rows);
  EXPECT_NEAR(static_cast<double>(thinned.rows), static_cast<double>(whole.rows) / 20, 2);
  for (std::size_t i = 0; i < thinned.rows; i += 50) {  // the rows that remain are the same
    EXPECT_EQ(thinned["height_m"][i], at(whole, "height_m", thinned["time_s"][i]));
  }
  for (std::size_t i = 0; i < few.rows; i += 50) {
    EXPECT_EQ(few["gyro_bias_x_deg_s"][i], at(all, "gyro_bias_x_deg_s", few["time_s"][i]));
  }
}

// What an earlier replay with a smoother left would be taken for this one's.
TEST(Replay, LeavesNoOutputsOfAnEarlierRunThatAreNotIts) {
  const SkiRun run;
  ASSERT_EQ(run.replay().code, 0);
  run.replace(SkiRun::kConfig, "smoother: rts", "smoother: none");
  ASSERT_EQ(run.replay().code, 0);
  EXPECT_FALSE(fs::exists(run.folder / "result/smoothed.csv"));
  EXPECT_FALSE(fs::exists(run.folder / "result/biases_smoothed.csv"));
}

TEST(Replay, QuietSaysNothing) {
  const SkiRun run;
  const Said said = run.replay({SkiRun::kConfig, "--output", "result", "--quiet"});
  EXPECT_EQ(said.code, 0);
  EXPECT_EQ(said.out + said.err, "");
}

TEST(Replay, TheVerdictNamesALeverArmThatIsWrong) {
  const SkiRun run;
  run.replace(SkiRun::kConfig, "-0.06 0.03 -0.42 m", "-60 30 -420 m");
  const Said said = run.replay();
  EXPECT_EQ(said.code, 0);
  EXPECT_TRUE(contains(said.err, "warning: sigmas are too small by ")) << said.err;
  const YAML::Node verdict = YAML::Load(run.text("result/summary.json"))["verdict"];
  EXPECT_FALSE(verdict["consistent"].as<bool>());
  EXPECT_GT(verdict["sources"]["gnss[0].position"]["rejected"].as<double>(), 0.2);
  EXPECT_TRUE(verdict["findings"][0].as<std::string>().starts_with("lever arm (-0.0")) << verdict["findings"][0];
  EXPECT_TRUE(contains(run.text("result/report.html"), "sigmas are too small by "));
}

TEST(Replay, TheLastLineIsTheVerdict) {
  const SkiRun run;
  const Said said = run.replay({SkiRun::kConfig, "--output", "result"});
  EXPECT_TRUE(said.out.ends_with("sigmas hold\n")) << said.out;
  EXPECT_TRUE(contains(run.text("result/report.html"), "<strong>sigmas hold</strong>"));
}

TEST(Replay, HelpAndVersion) {
  const TemporaryFolder folder;
  const Said help = run_program(program("replay"), {"--help"}, folder);
  EXPECT_EQ(help.code, 0);
  for (const char* part : {"CONFIG", "--output", "--quiet", "--help"}) EXPECT_TRUE(contains(help.out, part));
  EXPECT_EQ(help.err, "");
  EXPECT_EQ(run_program(program("replay"), {"--version"}, folder).code, 0);
}

TEST(Replay, WrongUsage) {
  const TemporaryFolder folder;
  const std::vector<std::vector<std::string>> wrong{
      {}, {"--ouput", "x", "a.yaml"}, {"a.yaml", "b.yaml"}, {"a.yaml", "--output"}, {"a.yaml"}, {"."}};
  for (const auto& words : wrong) {
    const Said said = run_program(program("replay"), words, folder);
    EXPECT_EQ(said.code, 2);
    EXPECT_EQ(said.out, "");
    EXPECT_NE(said.err, "");
  }
  EXPECT_TRUE(contains(run_program(program("replay"), {"a.yaml"}, folder).err, "a.yaml"));
  EXPECT_EQ(names_in(folder.path()), (std::set<std::string>{".err", ".out"}));
}

TEST(Replay, DefaultOutputIsNamedAfterTheConfiguration) {
  const SkiRun run;
  ASSERT_EQ(run.replay({SkiRun::kConfig}).code, 0);
  EXPECT_TRUE(fs::exists(run.folder / "out/ski_run/filtered.csv"));
}

TEST(Replay, OutputThatCannotBe) {
  const SkiRun run;
  run.write("occupied", "a file");
  for (const char* output : {"occupied", "occupied/below", "/proc/piste"}) {
    const Said said = run.replay({SkiRun::kConfig, "--output", output});
    EXPECT_EQ(said.code, 2) << output;
    EXPECT_TRUE(contains(said.err, output));
    EXPECT_TRUE(contains(said.err, "--output"));
  }
  EXPECT_EQ(run.text("occupied"), "a file");
}

TEST(Replay, AnErrorLeavesAnEarlierResultAsItWas) {
  const SkiRun run;
  ASSERT_EQ(run.replay().code, 0);
  const auto names = names_in(run.folder / "result");
  const std::string before = run.text("result/filtered.csv"), attitude = run.text("result/attitude.csv");
  const std::string summary = run.text("result/summary.json");
  const std::string gnss = run.text(SkiRun::kGnss);
  run.write(SkiRun::kGnss, gnss.substr(0, gnss.size() - 40));
  EXPECT_EQ(run.replay().code, 1);
  EXPECT_EQ(names_in(run.folder / "result"), names);
  EXPECT_TRUE(run.text("result/filtered.csv") == before);
  EXPECT_TRUE(run.text("result/attitude.csv") == attitude);
  EXPECT_TRUE(run.text("result/summary.json") == summary);
}

TEST(Replay, PicturesAreWhole) {
  const SkiRun run;
  ASSERT_EQ(run.replay().code, 0);
  EXPECT_TRUE(contains(run.text("result/trajectory.kml"), "</kml>"));
  const std::string report = run.text("result/report.html");
  EXPECT_TRUE(contains(report, "</html>"));
  EXPECT_TRUE(contains(report, "smoother: rts"));  // the configuration
  for (const char* network : {"src=\"http", "href=\"http", "url(http", "@import"}) {
    EXPECT_EQ(report.find(network), std::string::npos) << network;
  }
}

}  // namespace
}  // namespace piste::test
