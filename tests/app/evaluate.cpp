// `evaluate` as its user sees it: what it writes, says and returns.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "support/places.h"
#include "support/program.h"

namespace piste::test {
namespace {

const std::string kTruth = kSource / "data/ski_run/truth.csv", kFixes = kSource / "data/ski_run/gnss.csv";

Said evaluate(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"--output", "out"});
  return run_program(program("evaluate"), words, folder);
}

TEST(EvaluateApp, WritesWhatItFound) {
  const TemporaryFolder folder;
  const Said said = evaluate(folder, {kFixes, kTruth, "--align", "yaw", "--rpe", "50m", "--rpe", "2s"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("epochs of ski_run/gnss.csv against ski_run/truth.csv"), std::string::npos) << said.out;
  const YAML::Node found = YAML::LoadFile(folder / "out/evaluation.json");
  EXPECT_EQ(found["align"]["kind"].as<std::string>(), "yaw");
  EXPECT_EQ(found["align"]["rotation"].size(), 3u);
  EXPECT_GT(found["epochs"].as<int>(), 2000);
  EXPECT_LT(found["ape"]["rmse_m"].as<double>(), 0.5);  // the antenna against the body
  EXPECT_TRUE(found["ape"]["rotation"].IsNull());       // fixes have no attitude
  EXPECT_GT(found["rpe"]["50 m"]["pairs"].as<int>(), 5);
  EXPECT_GT(found["rpe"]["2 s"]["pairs"].as<int>(), 50);
  EXPECT_EQ(found["within_sigma"]["north_m"].size(), 3u);
  EXPECT_FALSE(found["within_sigma"]["roll_deg"].IsDefined());
  EXPECT_NE(read_text(folder / "out/evaluation.html").find("<svg"), std::string::npos);
  const std::string csv = read_text(folder / "out/evaluation.csv");
  EXPECT_EQ(csv.substr(0, csv.find(',')), "time_s");
}

// The truth is its own reference, and has no sigma.
TEST(EvaluateApp, HasNoSharesWithoutSigmas) {
  const TemporaryFolder folder;
  ASSERT_EQ(evaluate(folder, {kTruth, kTruth}).code, 0);
  const YAML::Node found = YAML::LoadFile(folder / "out/evaluation.json");
  EXPECT_EQ(found["ape"]["max_m"].as<double>(), 0);
  EXPECT_EQ(found["ape"]["rotation"]["max_deg"].as<double>(), 0);
  EXPECT_EQ(found["within_sigma"].size(), 0u);
}

TEST(EvaluateApp, RefusesWithoutACommonTime) {
  const TemporaryFolder folder;
  folder.write("other.tum", "10 0 0 0 0 0 0 1\n11 1 0 0 0 0 0 1\n");
  const Said said = evaluate(folder, {"other.tum", kTruth});
  EXPECT_EQ(said.code, 1);
  EXPECT_NE(said.err.find("10.000 to 11.000 s"), std::string::npos) << said.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(EvaluateApp, RefusesWrongUsage) {
  const TemporaryFolder folder;
  EXPECT_EQ(evaluate(folder, {kTruth}).code, 2);
  EXPECT_EQ(evaluate(folder, {kTruth, kTruth, "--align", "se4"}).code, 2);
  EXPECT_EQ(evaluate(folder, {kTruth, kTruth, "--rpe", "100 kg"}).code, 2);
  EXPECT_EQ(evaluate(folder, {kTruth, kTruth, "--time-offset", "soon"}).code, 2);
  EXPECT_EQ(evaluate(folder, {kTruth, "nowhere.csv"}).code, 1);
  EXPECT_EQ(evaluate(folder, {kTruth, kTruth, "--format-a", "gpx"}).code, 2);
}

}  // namespace
}  // namespace piste::test
