#include "piste/sim/campaign.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "piste/configuration/sensor_file.h"
#include "piste/math/units.h"
#include "piste/sim/simulation.h"
#include "support/article.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;

const std::filesystem::path kConfig = test::kSource / "config";

const Campaign& shipped() {
  static const Campaign campaign = read_campaign(kConfig / "scenarios" / "campaign.yaml");
  return campaign;
}

TEST(Campaign, ShippedHasTheRunsOfTheArticle) {
  const Campaign& c = shipped();
  EXPECT_NEAR(c.low_pass, 12, 1e-12);
  EXPECT_EQ(c.mems, (std::vector<std::string>{"MT-9A 1", "MT-9A 2", "MT-9A 3"}));
  ASSERT_EQ(c.runs.size(), 9U);
  std::size_t ski = 0;
  for (const CampaignRun& run : c.runs) {
    ski += run.activity == "ski" ? 1 : 0;
    EXPECT_EQ(run.scenario.motion.rest_before, 180);
    EXPECT_EQ(run.scenario.motion.run, 90);
    EXPECT_EQ(run.scenario.motion.rest_after, 180);
    EXPECT_EQ(run.scenario.imus[run.reference].name, "ln200");
    EXPECT_EQ(run.scenario.gnss[run.gnss].name, "gnss_l1l2");
    EXPECT_EQ(run.mems, (std::vector<std::size_t>{0, 1, 2}));
    for (const double rms : run.scenario.motion.vibration) {
      EXPECT_GE(rms, 0.5);
      EXPECT_LE(rms, 3);
    }
  }
  EXPECT_EQ(ski, 6U);
}

// A correction of S_LN = (1 + fe) S_MEMS + b undoes the error that is put in, to the digits of the files.
TEST(Campaign, ErrorsAreThoseOfTablesOneAndFour) {
  const CampaignTables article = test::bonnaz_2008().article.tables;
  for (const CampaignRun& run : shipped().runs) {
    for (std::size_t m = 0; m < 3; ++m) {
      const ImuSetup& imu = run.scenario.imus[run.mems[m]];
      for (std::size_t axis = 0; axis < 6; ++axis) {
        const TriadTruth& triad = axis < 3 ? imu.accel : imu.gyro;
        const double unit = axis < 3 ? 1 : kDegreesPerRadian;
        const int i = static_cast<int>(axis % 3);
        ASSERT_TRUE(triad.bias && triad.scale);
        const Printed &rest = article.rest.sensors[m][axis], &printed = article.joint_scale.sensors[m][axis];
        const double gain = 1 + printed.value, bias = unit * (*triad.bias)(i), scale = (*triad.scale)(i);
        EXPECT_NEAR(gain * (1 + scale), 1, 1e-6) << axis;
        EXPECT_NEAR(gain * bias + rest.value, 0, 1e-5) << axis;
        EXPECT_NEAR(gain * unit * triad.bias_spread(i), rest.std, 1e-5) << axis;
        EXPECT_NEAR(gain * gain * triad.scale_spread(i), printed.std, 1e-6) << axis;
      }
    }
  }
}

// Table 5 of the article, and the means that its Tables 3, 4 and 6 imply.
TEST(Campaign, SignalsGiveTheCorrelationsOfTheArticle) {
  Vector3d accel[3], gyro[3], force = Vector3d::Zero();
  for (int m = 0; m < 3; ++m) accel[m] = gyro[m] = Vector3d::Zero();
  for (const CampaignRun& run : shipped().runs) {
    const Scenario& s = run.scenario;
    const Truth trunk(World(s.origin), s.motion, run_seed(shipped().seed, run.name), s.start_time);
    const Truth plate = trunk.attached(s.q_tr, Vector3d::Zero());
    const Interval way = plate.under_way();
    for (std::size_t m = 0; m < 3; ++m) {
      const ImuSetup& imu = s.imus[run.mems[m]];
      const Truth body = plate.attached(imu.q_rb, imu.p_rb_r);
      TriadDraw f, w;
      double count = 0;
      for (double t = way.start; t < way.end; t += 0.04, ++count) {
        const TruthState state = body.at(t);
        f.run.mean += state.f_ib_b;
        f.run.rms += state.f_ib_b.cwiseAbs2();
        w.run.mean += state.w_ib_b;
        w.run.rms += state.w_ib_b.cwiseAbs2();
      }
      for (PhaseDraw* signal : {&f.run, &w.run}) {
        signal->mean /= count;
        signal->rms = (signal->rms / count).cwiseSqrt();
      }
      accel[m] += bias_scale_correlation(f) / 9;
      gyro[m] += bias_scale_correlation(w) / 9;
      force += f.run.mean / 27;
      EXPECT_GT(w.run.rms.minCoeff() * kDegreesPerRadian, 3) << run.name;
      EXPECT_LT(w.run.rms.maxCoeff() * kDegreesPerRadian, 20) << run.name;
    }
  }
  for (const Vector3d& a : accel) EXPECT_LT((a - Vector3d(.96, .33, .98)).cwiseAbs().maxCoeff(), .04) << a.transpose();
  for (const Vector3d& g : gyro) EXPECT_LT((g - Vector3d(.29, .48, .29)).cwiseAbs().maxCoeff(), .08) << g.transpose();
  EXPECT_LT((force - Vector3d(-6.5, -.19, -7.2)).cwiseAbs().maxCoeff(), .4) << force.transpose();
  EXPECT_NEAR(force.y(), -.19, .05);
}

class CampaignFile : public testing::Test {
 protected:
  // A campaign of the shipped scenarios; `runs` begins in line 6.
  Campaign read(const std::string& runs, const std::string& before = kBefore) {
    return read_campaign(folder_.write("c.yaml", before + runs));
  }
  std::string refusal(const std::string& runs, const std::string& before = kBefore) {
    return message_of<ConfigError>([&] { read(runs, before); });
  }
  static std::string run(const std::string& name, const std::string& more = "") {
    return "  - {name: " + name + ", activity: ski, scenario: " + (kConfig / "scenarios/campaign/ski.yaml").string() +
           more + "}\n";
  }

  static constexpr const char* kBefore =
      "seed: 3\nlow_pass: 8 Hz\nreference: ln200\ngnss: gnss_l1\nmems: [{imu: mt9a_3, name: third}]\n";
  test::TemporaryFolder folder_;
};

TEST_F(CampaignFile, RunsLayTheirMotionOverTheScenarios) {
  const Campaign c = read("runs:\n" + run("a") + run("b", ", motion: {speed: 11 m/s, net_turn: -90 deg}"));
  ASSERT_EQ(c.runs.size(), 2U);
  const MotionOptions &a = c.runs[0].scenario.motion, &b = c.runs[1].scenario.motion;
  EXPECT_EQ(a.speed, 9);
  EXPECT_EQ(b.speed, 11);
  EXPECT_NEAR(b.net_turn * kDegreesPerRadian, -90, 1e-12);
  EXPECT_EQ(a.cycle, b.cycle);
  EXPECT_EQ(a.sway_rate, b.sway_rate);
  EXPECT_EQ(c.runs[0].mems, std::vector<std::size_t>{2});
  EXPECT_EQ(c.runs[0].gnss, 1U);
  EXPECT_NE(run_seed(c.seed, "a"), run_seed(c.seed, "b"));
  EXPECT_NE(run_seed(c.seed, "a"), run_seed(c.seed + 1, "a"));
  EXPECT_LT(run_seed(c.seed, "a"), 1ULL << 32U);
}

TEST_F(CampaignFile, IsToldFromAScenario) {
  EXPECT_TRUE(is_campaign(kConfig / "scenarios" / "campaign.yaml"));
  EXPECT_FALSE(is_campaign(kConfig / "scenarios" / "ski.yaml"));
}

TEST_F(CampaignFile, BecomesTheFileOfTheStudy) {
  const Campaign c = read("runs:\n" + run("a") + run("b"));
  const YAML::Node study = YAML::Load(campaign_text(c, 5));
  EXPECT_EQ(study.size(), 2U);
  EXPECT_EQ(study["low_pass"].as<std::string>(), "8 Hz");
  ASSERT_EQ(study["runs"].size(), 2U);
  const YAML::Node b = study["runs"][1];
  EXPECT_EQ(b["name"].as<std::string>(), "b");
  EXPECT_EQ(b["activity"].as<std::string>(), "ski");
  EXPECT_EQ(b["phases"].as<std::string>(), "auto");
  EXPECT_EQ(b["truth"].as<std::string>(), "b/truth.json");
  EXPECT_EQ(b["reference"]["file"].as<std::string>(), "b/ln200.csv");
  EXPECT_EQ(b["reference"]["sensor"].as<std::string>(), "sensors/ln200.yaml");
  EXPECT_EQ(b["gnss"]["file"].as<std::string>(), "b/gnss_l1.csv");
  EXPECT_EQ(b["gnss"]["lever_arm"].as<std::string>(), "-0.05 0.02 -0.42 m");
  ASSERT_EQ(b["mems"].size(), 1U);
  EXPECT_EQ(b["mems"][0]["name"].as<std::string>(), "third");
  EXPECT_EQ(b["mems"][0]["file"].as<std::string>(), "b/mt9a_3.csv");
  EXPECT_EQ(b["mems"][0]["axes"].as<std::string>(), "+x +y +z");
  EXPECT_EQ(b["mems"][0]["sampling"].as<std::string>(), "mean");
}

TEST_F(CampaignFile, TheArticleGoesAlongWithTheLogs) {
  folder_.write("papers/a.yaml", "title: of an article, whose rest nobody reads here\n");
  const std::string runs = "runs:\n" + run("a"), known = "seed: 3\nlow_pass: 8 Hz\nreference: ln200\ngnss: gnss_l1\n",
                    mems = "mems: [{imu: mt9a_3, name: third, article_sensor: 'C: 3'}, {imu: mt9a_1, name: first}]\n";
  const Campaign c = read(runs + "article: papers/a.yaml\n", known + mems);
  EXPECT_EQ(c.files.at("articles/a.yaml"), "title: of an article, whose rest nobody reads here\n");
  const YAML::Node file = YAML::Load(campaign_text(c, 1));
  EXPECT_EQ(file["article"].as<std::string>(), "articles/a.yaml");
  EXPECT_EQ(file["article_sensors"]["third"].as<std::string>(), "C: 3");
  EXPECT_EQ(file["article_sensors"].size(), 1U) << "the other has no counterpart";
  EXPECT_FALSE(contains(campaign_text(read(runs), 1), "article"));
  EXPECT_TRUE(contains(refusal(runs + "article: none.yaml\n"), "c.yaml:8: article"));
  EXPECT_TRUE(contains(refusal(runs, known + mems), "c.yaml:5: unknown key `article_sensor`")) << "of no article";
  folder_.write("papers/b.yaml", "base: a.yaml\n");
  EXPECT_TRUE(contains(refusal(runs + "article: papers/b.yaml\n"), "c.yaml:8: article: builds on another file"));
}

TEST_F(CampaignFile, SensorFilesStandAlone) {
  const Campaign c = read("runs:\n" + run("a"));
  ASSERT_EQ(c.files.size(), 2U);
  EXPECT_EQ(c.files.at("sensors/ln200.yaml"), test::read_text(kConfig / "sensors/ln200.yaml"));

  // One that builds on another comes without it, and says the same.
  const std::string optimistic = (kConfig / "sensors/xsens_mt9a_optimistic.yaml").string();
  folder_.write("s.yaml", "base: " + (kConfig / "scenarios/campaign/ski.yaml").string() + "\nimus:\n" +
                              "  - {name: mt9a_3, sensor: " + optimistic +
                              "}\n  - {name: ln200, sensor: " + (kConfig / "sensors/ln200.yaml").string() + "}\n");
  const Campaign built = read("runs:\n  - {name: a, activity: ski, scenario: s.yaml}\n");
  const ImuSensor sensor =
      read_sensor(folder_.write("copy.yaml", built.files.at("sensors/xsens_mt9a_optimistic.yaml")));
  EXPECT_EQ(sensor.gyro.noise, read_sensor(optimistic).gyro.noise);
  EXPECT_EQ(sensor.accel.range, read_sensor(optimistic).accel.range);
}

TEST_F(CampaignFile, RefusesWithTheLineAndTheRemedy) {
  const std::pair<std::string, std::string> runs[] = {
      {"runs: []\n", "c.yaml:6: runs: name at least one"},
      {"runs:\n" + run("a") + run("a"), "c.yaml:8: name: `a` is taken"},
      {"runs:\n" + run("sensors"), "c.yaml:7: name: `sensors` is taken"},
      {"runs:\n" + run("Ski 1"), "c.yaml:7: name: `Ski 1` becomes a file name"},
      {"runs:\n" + run("../a"), "c.yaml:7: name: `../a` becomes a file name"},
      {"runs:\n" + run("-a"), "c.yaml:7: name: `-a` becomes a file name"},
      {"runs:\n" + run("a", ", moton: {speed: 1 m/s}"), "c.yaml:7: unknown key `moton`, perhaps `motion`"},
      {"runs:\n" + run("a", ", motion: {sped: 1 m/s}"), "c.yaml:7: unknown key `sped`, perhaps `speed`"},
      {"runs:\n" + run("a", ", motion: {run: 3 s}"), "c.yaml:7: motion: run must be longer"},
      {"runs:\n" + run("a", ", motion: {speed: 3}"), "c.yaml:7: speed: `3` has no unit"},
      {"runs:\n  - {name: a, activity: ski, scenario: none.yaml}\n", "c.yaml:7: scenario: there is no file"},
      {"runs:\n  - {name: a, activity: '', scenario: none.yaml}\n", "c.yaml:7: activity: names files and rows"},
      {"runs:\n  - {name: a, scenario: none.yaml}\n", "c.yaml:7: key `activity` is missing"},
      {"", "c.yaml:1: runs: name at least one"},
  };
  for (const auto& [text, expected] : runs) EXPECT_TRUE(contains(refusal(text), expected)) << text;

  const std::string one = "runs:\n" + run("a");
  const std::pair<std::string, std::string> before[] = {
      {"low_pass: 0 Hz\n", "c.yaml:1: low_pass: must be above zero"},
      {"low_pass: 8\n", "c.yaml:1: low_pass: `8` has no unit"},
      {"seed: -1\nlow_pass: 8 Hz\n", "c.yaml:1: seed: must not be negative"},
      {"low_pass: 8 Hz\nmems: []\n", "c.yaml:2: mems: name at least one IMU"},
      {"low_pass: 8 Hz\nmems: [{imu: ln200, name: x}]\nreference: ln200\n", "c.yaml:3: reference: stands among `mems`"},
      {"low_pass: 8 Hz\nmems: [{imu: mt9a_1, name: x}, {imu: mt9a_1, name: y}]\n", "c.yaml:2: imu: `mt9a_1` stands"},
      {"low_pass: 8 Hz\nmems: [{imu: mt9a_1, name: x}, {imu: mt9a_2, name: x}]\n", "c.yaml:2: name: `x` is taken"},
      {"low_pass: 8 Hz\nmems: [{imu: mt9a_1, name: 'x, y'}]\n", "c.yaml:2: name: names files and rows of tables"},
      {"low_pass: 8 Hz\nmems: [{imu: mt9a_1, name: x}]\nreference: ln20\ngnss: gnss_l1\n",
       "ski.yaml has no `ln20`, perhaps `ln200`"},
      {"low_pass: 8 Hz\nmems: [{imu: mt9a_1, name: x}]\nreference: ln200\ngnss: l1\n", "c.yaml:4: gnss: "},
      {"low_pass: 8 Hz\nmems: [{imu: mt9_1, name: x}]\nreference: ln200\ngnss: gnss_l1\n", "c.yaml:2: mems: "},
      {std::string(kBefore) + "speed: 8 m/s\n", "c.yaml:6: unknown key `speed`"},
  };
  for (const auto& [text, expected] : before) EXPECT_TRUE(contains(refusal(one, text), expected)) << text;
}

TEST_F(CampaignFile, TwoSensorFilesOfOneNameAreRefused) {
  folder_.write("other/ln200.yaml", "name: LN200\ngyro: {noise: 1 deg/s/sqrt(Hz)}\naccel: {noise: 1 mg/sqrt(Hz)}\n");
  folder_.write("s.yaml", "base: " + (kConfig / "scenarios/campaign/ski.yaml").string() + "\nimus:\n" +
                              "  - {name: mt9a_3, sensor: " + (kConfig / "sensors/xsens_mt9a.yaml").string() +
                              "}\n  - {name: ln200, sensor: other/ln200.yaml}\n");
  EXPECT_TRUE(contains(refusal("runs:\n" + run("a") + "  - {name: b, activity: ski, scenario: s.yaml}\n"),
                       "c.yaml:8: scenario: "));
}

}  // namespace
}  // namespace piste
