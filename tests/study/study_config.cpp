#include "piste/study/study_config.h"

#include <gtest/gtest.h>

#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

constexpr const char* kSensor =
    "name: test\n"
    "gyro: {noise: 0.05 deg/s/sqrt(Hz), bias: 0.5 deg/s, scale: 0 ppm, range: 300 deg/s, drift: {process: none}}\n"
    "accel: {noise: 200 ug/sqrt(Hz), bias: 0.05 m/s^2, scale: 20000 ppm, range: 2 g, drift: {process: none}}\n";
const std::string kRun =
    "runs:\n"
    "  - name: ski-1\n"
    "    activity: ski\n"
    "    reference: {file: ski-1/ln200.csv, sensor: sensor.yaml, axes: +y +x -z}\n"
    "    gnss: {file: ski-1/gnss.csv, lever_arm: -0.05 0.02 -0.42 m}\n"
    "    phases: auto\n"
    "    mems:\n"
    "      - {name: MT-9A 1, file: ski-1/mt9a_1.csv, sensor: sensor.yaml, clock: {offset: 3 s}}\n"
    "      - {name: MT-9A 2, file: ski-1/mt9a_2.csv, sensor: sensor.yaml, sampling: instant}\n";

struct StudyConfigTest : ::testing::Test {
  TemporaryFolder folder;
  StudyConfigTest() { folder.write("sensor.yaml", kSensor); }
  StudyConfig read(const std::string& text) { return read_study_config(folder.write("campaign.yaml", text)); }
  std::string refused(const std::string& text) {
    return message_of<ConfigError>([&] { read(text); });
  }
  // The usual run with one line replaced.
  static std::string with(const std::string& line, const std::string& by) {
    std::string text = kRun;
    const auto place = text.find(line);
    EXPECT_NE(place, std::string::npos);
    return text.replace(place, line.size(), by);
  }
};

TEST_F(StudyConfigTest, TheWholeContract) {
  const StudyConfig study = read("low_pass: 8 Hz\n" + kRun);
  EXPECT_EQ(study.low_pass, 8);
  ASSERT_EQ(study.runs.size(), 1U);
  const RunConfig& run = study.runs[0];
  EXPECT_EQ(run.name, "ski-1");
  EXPECT_EQ(run.activity, "ski");
  EXPECT_EQ(run.reference.source.log.file, folder / "ski-1/ln200.csv");
  EXPECT_EQ(run.reference.conditioning.imu.R_bs(0, 1), 1);
  ASSERT_TRUE(run.gnss);
  EXPECT_EQ(run.gnss->log.file, folder / "ski-1/gnss.csv");
  EXPECT_EQ(run.gnss->options.lever_arm, Vector3d(-0.05, 0.02, -0.42));
  EXPECT_FALSE(run.phases);
  EXPECT_FALSE(run.truth);
  ASSERT_EQ(run.mems.size(), 2U);
  EXPECT_EQ(run.mems[0].name, "MT-9A 1");
  EXPECT_EQ(run.mems[0].conditioning.imu.clock_offset, 0) << "is what the alignment finds";
  EXPECT_TRUE(run.mems[1].conditioning.imu.instantaneous);
  EXPECT_EQ(run.mems[1].conditioning.accel_range, 2 * kStandardGravity);
}

TEST_F(StudyConfigTest, WhatMayBeLeftOut) {
  EXPECT_EQ(read(kRun).low_pass, 12);
  const StudyConfig study =
      read(with("    gnss: {file: ski-1/gnss.csv, lever_arm: -0.05 0.02 -0.42 m}\n    phases: auto",
                "    phases: {run: [10 s, 100 s]}\n    truth: ski-1/truth.json"));
  EXPECT_FALSE(study.runs[0].gnss);
  ASSERT_TRUE(study.runs[0].phases);
  EXPECT_FALSE(study.runs[0].phases->before);
  EXPECT_EQ(study.runs[0].phases->run->end, 100);
  EXPECT_EQ(study.runs[0].truth->string(), folder / "ski-1/truth.json");
}

TEST_F(StudyConfigTest, MistakesAreNamedWithTheirLine) {
  EXPECT_TRUE(contains(refused("low_pass: 12 Hz\n"), "runs"));
  EXPECT_TRUE(contains(refused("low_pass: 0 Hz\n" + kRun), "campaign.yaml:1"));
  EXPECT_TRUE(contains(refused("low_pas: 12 Hz\n" + kRun), "campaign.yaml:1"));
  EXPECT_TRUE(contains(refused(with("activity:", "activty:")), "campaign.yaml:3"));
  EXPECT_TRUE(contains(refused(with("MT-9A 2", "MT-9A 1")), "campaign.yaml:9"));
  EXPECT_TRUE(contains(refused(with("ski-1/mt9a_2.csv", "ski-1/ln200.csv")), "campaign.yaml:9: file: is the log of"));
  EXPECT_TRUE(contains(refused(with("ski-1/mt9a_2.csv", "ski-1/mt9a_1.csv")), "campaign.yaml:9: file: is the log of"));
  EXPECT_TRUE(contains(refused(with("sensor: sensor.yaml, sampling", "sensor: none.yaml, sampling")), "none.yaml"));
  EXPECT_TRUE(contains(refused(kRun + kRun.substr(6)), "stands for two runs"));
  EXPECT_TRUE(contains(refused(with("lever_arm: -0.05 0.02 -0.42 m", "lever_arm: 5 cm")), "campaign.yaml:5"));
}

TEST_F(StudyConfigTest, AnArticleIsNamedByItsFileAndItsSensorsByTheirNames) {
  folder.write("papers/a.yaml",
               "title: t\nsensors: [left, right]\ntables:\n  rest:\n    name: Table I\n    rows:\n"
               "      - {sensor: right, accel: 1 2 3 m/s^2, gyro: 1 2 3 deg/s}\n");
  EXPECT_FALSE(read(kRun).article);
  const std::string article = "article: papers/a.yaml\n";
  EXPECT_TRUE(read(article + kRun).article->counterparts.empty());
  const StudyConfig study = read(article + "article_sensors: {MT-9A 2: right}\n" + kRun);
  const PrintedTable& rest = study.article->article.tables.rest;
  EXPECT_EQ(study.article->row(rest, "MT-9A 1"), nullptr);
  ASSERT_NE(study.article->row(rest, "MT-9A 2"), nullptr);
  EXPECT_EQ((*study.article->row(rest, "MT-9A 2"))[1].value, 2);

  EXPECT_TRUE(contains(refused("article: papers/b.yaml\n" + kRun), "campaign.yaml:1: article"));
  EXPECT_TRUE(contains(refused("article_sensors: {MT-9A 2: right}\n" + kRun), "campaign.yaml:1: article_sensors"));
  EXPECT_TRUE(contains(refused(article + "article_sensors: {MT-9A 2: middle}\n" + kRun),
                       "campaign.yaml:2: MT-9A 2: `middle` is no sensor of the article; it has: left, right"));
  EXPECT_TRUE(contains(refused(article + "article_sensors: {MT9A 2: right}\n" + kRun),
                       "campaign.yaml:2: unknown key `MT9A 2`, perhaps `MT-9A 2`"));
  folder.write("papers/a.yaml", "title: t\nsensor: [left]\n");
  EXPECT_TRUE(contains(refused(article + kRun), "papers/a.yaml:"));
}

TEST_F(StudyConfigTest, ACopyOfALogIsTheSameLog) {
  folder.write("ski-1/mt9a_1.csv", "time_s\n1\n");
  folder.write("ski-1/mt9a_2.csv", "time_s\n2\n");
  EXPECT_EQ(read(kRun).runs[0].mems.size(), 2U);
  folder.write("ski-1/mt9a_2.csv", "time_s\n1\n");
  EXPECT_TRUE(contains(refused(kRun), "ski-1/mt9a_1.csv`, or a copy of it"));
}

}  // namespace
}  // namespace piste
