// `allan` as its user sees it: what it writes, says and returns.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "piste/configuration/sensor_file.h"
#include "piste/math/units.h"
#include "report/well_formed.h"
#include "support/datasets.h"
#include "support/navigation.h"
#include "support/places.h"
#include "support/program.h"
#include "support/random.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

constexpr double kRate = 100, kGyro = 1e-3, kAccel = 5e-3;  // Hz; densities, SI
constexpr const char* kHead = "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n";

// An IMU at rest with white noise; the third gyroscope has twice that of the others.
std::string resting(double length, std::uint64_t seed, double scale = 1) {
  Random random(seed);
  std::string text = kHead;
  for (int i = 0; i < length * kRate; ++i) {
    const Vector3d gyro = random.vector(scale * kGyro * std::sqrt(kRate)),
                   accel = random.vector(scale * kAccel * std::sqrt(kRate));
    text += fmt::format("{:.2f},{:.8f},{:.8f},{:.8f},{:.6f},{:.6f},{:.6f}\n", i / kRate, gyro.x() + 0.01, gyro.y(),
                        2 * gyro.z(), accel.x(), accel.y(), accel.z() - 9.81);
  }
  return text;
}

struct AllanApp : ::testing::Test {
  TemporaryFolder folder;
  Said allan(std::vector<std::string> words) const { return run_program(program("allan"), words, folder); }
};

TEST_F(AllanApp, WritesTheContractAndASensorFileThatHoldsWhatWasPutIn) {
  folder.write("rest.csv", resting(300, 1));
  const Said said = allan({"rest.csv"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "gyro_z"));
  const ImuSensor sensor = read_sensor(folder / "out/rest/sensor.yaml");
  EXPECT_NEAR(sensor.gyro.densities().x() / kGyro, 1, 0.05);
  EXPECT_NEAR(sensor.gyro.densities().z() / kGyro, 2, 0.1);
  EXPECT_NEAR(sensor.accel.noise / kAccel, 1, 0.05);
  EXPECT_EQ(sensor.accel.densities().x(), sensor.accel.densities().y());  // they do not differ
  const YAML::Node json = YAML::LoadFile(folder / "out/rest/allan.json");
  const auto axis = json["axes"]["gyro_x"];
  EXPECT_LT(axis["noise"]["interval"][0].as<double>(), kGyro);
  EXPECT_GT(axis["noise"]["interval"][1].as<double>(), kGyro);
  EXPECT_EQ(axis["fit"]["model"].as<std::string>(), "white noise");
  const Table table = read_table(folder / "out/rest/allan.csv");
  EXPECT_DOUBLE_EQ(table["tau_s"][0], 1 / kRate);
  EXPECT_NEAR(table["gyro_x_adev"][0], kGyro * std::sqrt(kRate), 0.03 * kGyro * std::sqrt(kRate));
  EXPECT_EQ(not_well_formed(body_of(read_text(folder / "out/rest/allan.html"))), "");
}

TEST_F(AllanApp, TheSensorFileReplays) {
  folder.write("rest.csv", resting(120, 2, 0.5));
  ASSERT_EQ(allan({"rest.csv", "--output", "a", "--quiet"}).code, 0);
  folder.write("run.yaml", fmt::format("base: {}/config/ski_run.yaml\nimu: {{sensor: a/sensor.yaml}}\n"
                                       "span: {{start: 302400 s, end: 302520 s}}\n",
                                       kSource.string()));
  const Said said = run_program(program("replay"), {"run.yaml", "--output", "replayed"}, folder);
  EXPECT_EQ(said.code, 0) << said.err;
}

TEST_F(AllanApp, UnitsOfOneTypeStandBesideEachOther) {
  folder.write("a.csv", resting(200, 3));
  folder.write("b.csv", resting(120, 4, 1.5));
  const Said said = allan({"a.csv", "b.csv", "--output", "both"});
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node json = YAML::LoadFile(folder / "both/allan.json");
  const auto axis = json["axes"]["accel_x"];
  ASSERT_EQ(axis["units"].size(), 2u);
  const double a = axis["units"][0]["noise"]["value"].as<double>(), b = axis["units"][1]["noise"]["value"].as<double>();
  EXPECT_NEAR(b / a, 1.5, 0.1);
  EXPECT_NEAR(axis["spread_of_noise"].as<double>(), std::log(1.5) / std::sqrt(2), 0.05);
  EXPECT_EQ(not_well_formed(body_of(read_text(folder / "both/allan.html"))), "");
}

TEST_F(AllanApp, SaysWhatIsWrongAndWhatWouldBeRight) {
  const auto refused = [&](const std::vector<std::string>& words, int code, const std::string& part) {
    const Said said = allan(words);
    EXPECT_EQ(said.code, code) << said.err;
    EXPECT_TRUE(contains(said.err, part)) << said.err;
    EXPECT_EQ(said.out, "");
  };
  refused({"none.csv"}, 2, "there is no such file");
  folder.write("rest.csv", resting(70, 5));
  refused({"rest.csv", "--robst"}, 2, "--robst");
  refused({"rest.csv", "--sensor", "none.yaml"}, 2, "none.yaml");
  refused({"rest.csv", "--tuned", "rest.csv"}, 2, "tune.json");
  folder.write("short.csv", resting(8, 6));
  refused({"short.csv"}, 1, "the log lasts 7.990 s");
  folder.write("copy.csv", resting(70, 5));
  refused({"rest.csv", "copy.csv"}, 2, "copy.csv: is `rest.csv`, or a copy of it");
  folder.write("twice.yaml", "recordings:\n  - file: rest.csv\n  - file: rest.csv\n");
  refused({"twice.yaml"}, 2, "twice.yaml:3");
  folder.write("head.csv", kHead);
  refused({"head.csv"}, 1, "head.csv");
  refused({(kSource / "data/ski_run/gnss.csv").string()}, 1, "receiver");
  folder.write("allan.yaml", "recordings: [{file: rest.csv}]\nmodle: [white_noise]\n");
  refused({"allan.yaml"}, 2, "allan.yaml:2");
}

TEST_F(AllanApp, AnAxisThatDoesNotVaryIsSaidToBeSo) {
  std::string text = kHead;
  Random random(7);
  for (int i = 0; i < 100 * kRate; ++i) {
    const Vector3d gyro = random.vector(0.01);
    text += fmt::format("{:.2f},{:.8f},0,{:.8f},{:.6f},0,-9.81\n", i / kRate, gyro.x(), gyro.z(), gyro.y());
  }
  folder.write("stuck.csv", text);
  const Said said = allan({"stuck.csv", "--output", "a"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "gyro_y   not fitted")) << said.out;
  EXPECT_TRUE(contains(said.out, "gyro_y: not fitted: the samples do not vary")) << said.out;
}

// Lines in place of missing rows have no noise: where there are many, what is found is not to be believed.
TEST_F(AllanApp, ManyMissingRowsAreSaidToSpoilTheIntervals) {
  const std::string whole = resting(100, 9);
  const auto without_every = [&](int every) {
    std::string text;
    std::size_t begin = 0;
    for (int row = 0; begin < whole.size(); ++row) {
      const std::size_t end = whole.find('\n', begin) + 1;
      if (row % every != every - 1) text += whole.substr(begin, end - begin);
      begin = end;
    }
    return text;
  };
  folder.write("few.csv", without_every(500));
  folder.write("many.csv", without_every(20));
  const Said few = allan({"few.csv"}), many = allan({"many.csv"});
  ASSERT_EQ(few.code + many.code, 0) << few.err << many.err;
  EXPECT_TRUE(contains(few.out, "were bridged by straight lines")) << few.out;
  EXPECT_FALSE(contains(few.out, "intervals do not hold")) << few.out;
  EXPECT_TRUE(contains(many.out, "5 % of the rows are such lines")) << many.out;
}

TEST_F(AllanApp, AChangeOfTemperatureIsSaid) {
  const std::string rows = resting(100, 10).substr(std::string(kHead).size());
  const auto warming = [&](double rise) {
    std::string text = kHead;
    text.back() = ',';
    text += "temperature_degC\n";
    std::size_t begin = 0;
    for (int row = 0; begin < rows.size(); ++row) {
      const std::size_t end = rows.find('\n', begin);
      text += rows.substr(begin, end - begin) + fmt::format(",{:.3f}\n", 20 + rise * row / (100 * kRate));
      begin = end + 1;
    }
    return text;
  };
  folder.write("even.csv", warming(1));
  folder.write("warming.csv", warming(15));
  EXPECT_FALSE(contains(allan({"even.csv"}).out, "temperature"));
  EXPECT_TRUE(contains(allan({"warming.csv"}).out, "the temperature is 20.0 to 35.0"));
}

// Halves of a log with a knock in between: `--robust` bounds what it does.
TEST_F(AllanApp, RobustBoundsOutliers) {
  std::string text = kHead;
  Random random(8);
  for (int i = 0; i < 200 * kRate; ++i) {
    const Vector3d gyro = random.vector(kGyro * std::sqrt(kRate)), accel = random.vector(kAccel * std::sqrt(kRate));
    const double knock = i % 997 == 5 ? 0.3 : 0;
    text += fmt::format("{:.2f},{:.8f},{:.8f},{:.8f},{:.6f},{:.6f},{:.6f}\n", i / kRate, gyro.x() + knock, gyro.y(),
                        gyro.z(), accel.x(), accel.y(), accel.z() - 9.81);
  }
  folder.write("knocked.csv", text);
  ASSERT_EQ(allan({"knocked.csv", "--robust", "--at-rest", "--output", "a"}).code, 0);
  const double density = read_sensor(folder / "a/sensor.yaml").gyro.densities().x();
  EXPECT_NEAR(density / kGyro, 1, 0.06);
}

// A recorded ADIS16405, of which the values are counts: its steps, white noise and bias instability are told apart.
TEST_F(AllanApp, AnAdis16405AtRest) {
  PISTE_REQUIRE_DATASETS();
  const std::string counts = (datasets() / "adis16405/imu1_int16.xz").string();
  std::FILE* pipe = popen(fmt::format("xz --decompress --stdout '{}'", counts).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string text = kHead;
  std::array<std::int16_t, 6> row{};
  constexpr double kGyroStep = 0.05 * kDegree, kAccelStep = 3.33e-3 * 9.80665;
  for (int i = 0; std::fread(row.data(), sizeof row, 1, pipe) == 1; ++i) {
    text += fmt::format("{:.2f},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g}\n", i / kRate, kGyroStep * row[0],
                        kGyroStep * row[1], kGyroStep * row[2], kAccelStep * row[3], kAccelStep * row[4],
                        kAccelStep * row[5]);
  }
  pclose(pipe);
  folder.write("adis.csv", text);
  const Said said = allan({"adis.csv", "--output", "a"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "steps of 0.05 deg/s")) << said.out;
  const YAML::Node axes = YAML::LoadFile(folder / "a/allan.json")["axes"];
  for (const char* name : {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"}) {
    const bool gyro = name[0] == 'g';
    const double step = gyro ? kGyroStep : kAccelStep;
    EXPECT_NEAR(axes[name]["value_step"].as<double>(), step, 1e-4 * step) << name;
    // What the data sheet has: 2 deg/√h = 0.033 deg/s/√Hz and 0.007 deg/s; 0.2 m/s/√h = 0.0033 m/s²/√Hz and 0.2 mg.
    // Typical values, of which this unit's accelerometers are half as much again and more.
    const double noise = axes[name]["noise"]["value"].as<double>(),
                 instability = axes[name]["bias_instability"]["value"].as<double>();
    EXPECT_GT(noise, gyro ? 0.025 * kDegree : 0.003) << name;
    EXPECT_LT(noise, gyro ? 0.05 * kDegree : 0.008) << name;
    EXPECT_GT(instability, gyro ? 0.004 * kDegree : 0.001) << name;
    EXPECT_LT(instability, gyro ? 0.014 * kDegree : 0.006) << name;
  }
}

}  // namespace
}  // namespace piste::test
