#include "piste/io/solution_io.h"

#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "io/csv.h"
#include "piste/files/summary.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::TemporaryFolder;

Solution solution(std::size_t epochs, std::span<const Block> blocks) {
  Solution s(StateLayout(blocks), World({46 * kDegree, 7 * kDegree, 1600}));
  s.reserve(epochs);
  for (std::size_t i = 0; i < epochs; ++i) {
    Estimate x;
    x.q_wb = from_euler(Vector3d(1, -2, 30) * kDegree);
    x.v_wb = {10, 0.5, -0.25};
    x.gyro_bias = Vector3d(0.1, 0.2, -0.3) * kDegree;
    x.gyro_drift = Vector3d::Constant(0.01 * static_cast<double>(i) * kDegree);
    x.accel_scale = {0.01, 0, 0};
    x.q_rb = from_euler(Vector3d(3, -4, 5) * kDegree);
    x.gnss_delay = 0.02;
    Sigmas sigmas{{.position = {1, 2, 3}, .velocity = {.1, .2, .3}, .euler = Vector3d(.5, .6, .7) * kDegree}};
    sigmas.blocks.segment<3>(full_offset(Block::kGyroBias)) = Vector3d(1, 2, 3) * kDegree;
    sigmas.blocks.segment<3>(full_offset(Block::kBoresight)) = Vector3d(.1, .2, .3) * kDegree;
    sigmas.blocks(full_offset(Block::kGnssDelay)) = 0.001;
    sigmas.gyro_total_bias = Vector3d::Constant(0.5 * kDegree);
    s.append(1000 + 0.01 * static_cast<double>(i), x, sigmas);
  }
  return s;
}

const std::vector<Block> kAll{Block::kGyroBias,   Block::kGyroDrift, Block::kAccelBias,
                              Block::kAccelScale, Block::kBoresight, Block::kGnssDelay};

TEST(SolutionIo, NavigationReadsBack) {
  const TemporaryFolder folder;
  const Solution s = solution(3, kAll);
  CsvReader csv(folder.write("filtered.csv", navigation_csv(s)));
  EXPECT_EQ(
      fmt::format("{}", fmt::join(csv.names(), ",")),
      "time_s,latitude_deg,longitude_deg,height_m,velocity_north_m_s,velocity_east_m_s,velocity_down_m_s,roll_deg,"
      "pitch_deg,heading_deg,sigma_north_m,sigma_east_m,sigma_down_m,sigma_velocity_north_m_s,"
      "sigma_velocity_east_m_s,sigma_velocity_down_m_s,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg");
  const auto latitude = csv.column("latitude_deg"), heading = csv.column("heading_deg"),
             sigma = csv.column("sigma_pitch_deg"), down = csv.column("velocity_down_m_s");
  ASSERT_TRUE(csv.next());
  EXPECT_NEAR(csv[latitude], 46, 1e-10);
  EXPECT_NEAR(csv[heading], 30, 1e-7);
  EXPECT_NEAR(csv[sigma], 0.6, 1e-7);
  EXPECT_NEAR(csv[down], -0.25, 1e-5);
}

TEST(SolutionIo, AttitudeOfTheEpochsNearestToTheGrid) {
  const TemporaryFolder folder;
  const auto times = [&](const Solution& s, double rate) {
    CsvReader csv(folder.write("attitude.csv", attitude_csv(s, rate)));
    EXPECT_EQ(fmt::format("{}", fmt::join(csv.names(), ",")),
              "time_s,roll_deg,pitch_deg,heading_deg,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg");
    std::vector<double> read;
    for (const auto time = csv.column("time_s"); csv.next();) read.push_back(csv[time]);
    return read;
  };
  using Times = std::vector<double>;
  // 100 Hz from 1000 s on
  EXPECT_EQ(times(solution(31, {}), 10), (Times{1000, 1000.1, 1000.2, 1000.3}));
  EXPECT_EQ(times(solution(4, {}), 1000), (Times{1000, 1000.01, 1000.02, 1000.03}));  // sparser than the grid
  Solution off(StateLayout{}, World({46 * kDegree, 7 * kDegree, 1600}));
  for (const double t : {9.98, 10.03, 10.09, 10.15, 10.21, 15.04, 15.08, 15.12, 15.16}) off.append(t, {}, {});
  EXPECT_EQ(times(off, 10), (Times{9.98, 10.09, 10.21, 15.04, 15.08, 15.16}));  // a gap is no reason to repeat a row
  EXPECT_EQ(times(off, 0.1), (Times{9.98, 15.16}));
}

// Whether a row is the nearest to a multiple of the rate may depend on the first row of the next piece.
TEST(SolutionIo, RowsInPiecesGiveTheSameFile) {
  Solution all = solution(997, kAll);
  Estimate x;
  const Sigmas sigmas = all.sigmas(0);
  for (int i = 0; i < 300; ++i) {
    x.gyro_bias = Vector3d::Constant(1e-5 * i);
    all.append(1010 + 0.0137 * i, x, sigmas);
  }
  for (const RowFile kind : {RowFile::kNavigation, RowFile::kBiases, RowFile::kAttitude}) {
    for (const double rate : {0.0, 10.0, 47.0, 100.0, 500.0}) {
      const auto written = [&](std::size_t at_once) {
        std::string text;
        RowCsv csv(kind, all.layout(), rate, [&](std::string_view piece) { text += piece; });
        Solution piece(all.layout(), all.world());
        for (std::size_t i = 0; i < all.size(); ++i) {
          piece.append(all.time(i), all.estimate(i), all.sigmas(i));
          if (piece.size() < at_once && i + 1 < all.size()) continue;
          csv.add(piece);
          piece.resize(0);
        }
        csv.finish();
        return text;
      };
      const std::string whole = written(all.size());
      EXPECT_EQ(written(1), whole) << rate;
      EXPECT_EQ(written(7), whole) << rate;
      if (kind != RowFile::kAttitude) continue;
      EXPECT_EQ(attitude_csv(all, rate), whole);
    }
  }
}

TEST(SolutionIo, AttitudeReadsBackAsAnAttitudeLog) {
  const TemporaryFolder folder;
  Solution s(StateLayout{}, World({46 * kDegree, 7 * kDegree, 1600}));
  const Vector3d euler = Vector3d(1.2345678, -42.0000004, -179.9999) * kDegree, sigma = {7e-5, 5e-5, 4e-4};
  Estimate x;
  x.q_wb = from_euler(euler);
  s.append(302400.1, x, {{.position = {1, 2, 3}, .velocity = {.1, .2, .3}, .euler = sigma}});
  LogFile file;
  file.file = folder.write("attitude.csv", attitude_csv(s, 10));
  const AttitudeRecording read = read_attitude(file);
  ASSERT_EQ(read.fixes.size(), 1u);
  EXPECT_NEAR(read.fixes[0].time, 302400.1, 1e-6);
  EXPECT_LT((read.fixes[0].angles - euler).cwiseAbs().maxCoeff(), 1e-7 * kDegree);
  EXPECT_LT((read.fixes[0].sigma - sigma).cwiseAbs().maxCoeff(), 1e-7 * kDegree);
}

TEST(SolutionIo, SummarySaysHowLongTheAttitudesErrorLasts) {
  Solution s = solution(2, {});
  const auto entry = [&] { return YAML::Load(summary_json({}, s, nullptr, {}, {}))["attitude_error"]; };
  EXPECT_TRUE(entry()["correlation_time_s"].IsNull());
  EXPECT_NEAR(entry()["sigma_deg"][1].as<double>(), 0.6, 1e-9);
  s.attitude_correlation_time = 157.26;
  EXPECT_EQ(entry()["correlation_time_s"].as<double>(), 157.3);
  s.append(1001, {}, {{.position = {1, 2, 3}, .velocity = {.1, .2, .3}, .euler = Vector3d::Zero()}});
  EXPECT_NEAR(entry()["sigma_deg"][1].as<double>(), 0.6 * std::sqrt(2 / 3.0), 1e-9);  // rms
}

TEST(SolutionIo, BiasesOfTheEstimatedBlocksOnly) {
  const TemporaryFolder folder;
  const Solution s = solution(3, kAll);
  CsvReader csv(folder.write("biases.csv", biases_csv(s)));
  const auto bias = csv.column("gyro_bias_y_deg_s"), sigma = csv.column("sigma_gyro_bias_z_deg_s"),
             scale = csv.column("accel_scale_x_ppm"), heading = csv.column("boresight_heading_deg"),
             delay = csv.column("gnss_delay_s"), total = csv.column("gyro_total_bias_x_deg_s"),
             total_sigma = csv.column("sigma_gyro_total_bias_x_deg_s");
  EXPECT_TRUE(csv.find("accel_total_bias_x_m_s2"));
  EXPECT_FALSE(csv.find("lever_arm_x_m"));
  while (csv.next()) {
  }
  EXPECT_NEAR(csv[bias], 0.2, 1e-8);
  EXPECT_NEAR(csv[sigma], 3, 1e-8);
  EXPECT_NEAR(csv[scale], 10000, 1e-2);
  EXPECT_NEAR(csv[heading], 5, 1e-6);
  EXPECT_NEAR(csv[delay], 0.02, 1e-8);
  EXPECT_NEAR(csv[total], 0.12, 1e-8);
  EXPECT_NEAR(csv[total_sigma], 0.5, 1e-8);
}

TEST(SolutionIo, InnovationsHaveEmptyCellsForWhatWasNotMeasured) {
  Solution s = solution(1, kAll);
  s.sources = {"gnss[0].velocity", "barometer"};
  s.innovations = {{1002, 0, 2, {4, 5, 0}, {2, 3, 1}, 7, 13.8, Outcome::kUsed},
                   {1002, 1, 1, {4, 0, 0}, {2, 1, 1}, 4, 10.8, Outcome::kUsed},
                   {1003, 0, 3, {0, 0, 0}, {0, 0, 0}, 0, 0, Outcome::kRepeated}};
  const std::string csv = innovations_csv(s);
  EXPECT_TRUE(contains(csv, "\n1002.000000,gnss[0].velocity,4,5,,2,3,,7,13.8,used\n")) << csv;
  EXPECT_TRUE(contains(csv, "\n1002.000000,barometer,4,,,2,,,4,10.8,used\n")) << csv;
  EXPECT_TRUE(contains(csv, "\n1003.000000,gnss[0].velocity,,,,,,,0,0,repeated\n")) << csv;
}

TEST(SolutionIo, InnovationsAndSummary) {
  Solution s = solution(3, kAll);
  s.sources = {"gnss[0].position", "gnss[0].velocity", "attitude[0]"};
  s.innovations = {{1000, 0, 3, {1, 2, 3}, {1, 1, 1}, 14, 16.27, Outcome::kUsed},
                   {1000, 1, 3, {9, 2, 3}, {1, 1, 1}, 94, 16.27, Outcome::kRejected},
                   {1001, 0, 3, {0, 0, 0}, {1, 1, 1}, 0, 16.27, Outcome::kReadmitted},
                   {1001, 2, 3, {0, 0, 0}, {1, 1, 1}, 0, 16.27, Outcome::kUsed}};
  EXPECT_TRUE(contains(innovations_csv(s), "\n1000.000000,gnss[0].velocity,9,2,3,1,1,1,94,16.27,rejected\n"));

  Log log;
  log.counts = {.imu_gaps = 2,
                .imu_rejected = 0,
                .imu_clipped = 5,
                .gnss_withheld = {3, 4},
                .gnss_outside = {1},
                .attitude_outside = {6},
                .gnss_without_fix = {8, 1},
                .attitude_not_valid = {5}};
  log.speed = {{1000, 1, 0.1}};
  log.counts.speed_outside = 2;
  log.counts.height_outside = 3;
  log.counts.speed_repaired = {.sorted = 4, .dropped = 1};
  log.rest = {{1000, 1010.5}};
  const Verdict verdict{
      .consistent = false,
      .factor = 1.5,
      .sources = {{.name = "gnss[0].position", .fixes = 40, .nis = 2.25, .rejected = 0.125, .holds = false},
                  {.name = "attitude[0]", .fixes = 3}},
      .jumps = {{"gyro_scale z", -5.5}},
      .findings = {"lever arm (\"1\" m)", "noise"}};
  const std::string text = summary_json(log, s, nullptr, verdict, {1.5, 2});
  const YAML::Node json = YAML::Load(text);  // JSON is YAML
  EXPECT_EQ(json["imu"]["epochs"].as<int>(), 3);
  EXPECT_EQ(json["imu"]["gaps"].as<int>(), 2);
  EXPECT_EQ(json["gnss"]["used"].as<int>(), 1);
  EXPECT_EQ(json["gnss"]["rejected"].as<int>(), 1);
  EXPECT_EQ(json["gnss"]["withheld"].as<int>(), 7);
  EXPECT_EQ(json["gnss"]["without_fix"].as<int>(), 9);
  EXPECT_EQ(json["attitude"]["used"].as<int>(), 1);
  EXPECT_EQ(json["attitude"]["not_valid"].as<int>(), 5);
  EXPECT_EQ(json["odometer"]["outside"].as<int>(), 2);
  EXPECT_EQ(json["odometer"]["used"].as<int>(), 0);
  EXPECT_EQ(json["odometer"]["repaired"]["sorted"].as<int>(), 4);
  EXPECT_EQ(json["odometer"]["repaired"]["dropped"].as<int>(), 1);
  EXPECT_EQ(json["barometer"]["outside"].as<int>(), 3);
  EXPECT_FALSE(json["heading"]) << "it has none";
  EXPECT_EQ(json["sources"]["gnss[0].velocity"]["rejected"].as<int>(), 1);
  EXPECT_FALSE(json["verdict"]["consistent"].as<bool>());
  EXPECT_EQ(json["verdict"]["sources"]["gnss[0].position"]["nis"].as<double>(), 2.25);
  EXPECT_EQ(json["verdict"]["sources"]["gnss[0].position"]["rejected"].as<double>(), 0.125);
  EXPECT_TRUE(json["verdict"]["sources"]["attitude[0]"]["nis"].IsNull()) << "too few";
  EXPECT_EQ(json["verdict"]["jumps"]["gyro_scale z"].as<double>(), -5.5);
  EXPECT_EQ(json["verdict"]["findings"].as<std::vector<std::string>>(), verdict.findings);
  EXPECT_EQ(json["rest_intervals"][0][1].as<double>(), 1010.5);
  EXPECT_EQ(json["estimates"]["gyro_bias"]["unit"].as<std::string>(), "deg/s");
  EXPECT_NEAR(json["estimates"]["gyro_drift"]["value"][0].as<double>(), 0.02, 1e-9);
  EXPECT_NEAR(json["estimates"]["boresight"]["value"][1].as<double>(), -4, 1e-9);
  EXPECT_NEAR(json["estimates"]["boresight"]["sigma"][2].as<double>(), 0.3, 1e-9);
  EXPECT_EQ(json["estimates"]["gnss_delay"]["value"].size(), 1u);
  EXPECT_NEAR(json["gyro_total_bias"]["value"][0].as<double>(), 0.11, 1e-9);  // the mean over the run
  EXPECT_NEAR(json["gyro_total_bias"]["sigma"][0].as<double>(), 0.5, 1e-9);
  EXPECT_EQ(json["cpu_s"].as<double>(), 1.5);
}

TEST(SolutionIo, NothingEstimatedIsStillJson) {
  const Solution s = solution(1, {});
  const YAML::Node json = YAML::Load(summary_json({}, s, &s, {}, {}));
  EXPECT_EQ(json["estimates"].size(), 0u);
  EXPECT_EQ(biases_csv(s).substr(0, 7), "time_s\n");
}

}  // namespace
}  // namespace piste
