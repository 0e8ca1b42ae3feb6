// What an ensemble says, written and read again.

#include "piste/files/consistency.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>

#include "piste/math/units.h"
#include "piste/report/consistency_text.h"
#include "support/ensemble.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::added;
using test::contains;
using test::Ensemble;

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

TEST(ConsistencyJson, TellsTheReport) {
  const ConsistencyReport report = added({.runs = 20}).report();
  const std::string text = consistency_json(report, "a \"ski\" run");
  const YAML::Node json = YAML::Load(text);
  EXPECT_EQ(json["title"].as<std::string>(), "a \"ski\" run");
  EXPECT_EQ(json["runs"].as<int>(), 20);
  EXPECT_EQ(json["failures"].size(), 0U);
  EXPECT_EQ(json["probability"].as<double>(), 0.999);
  EXPECT_TRUE(json["consistent"].as<bool>());
  EXPECT_EQ(json["phases"]["rest"][0].as<double>(), -10);
  EXPECT_EQ(json["phases"]["under_way"][1].as<double>(), 45);
  for (const char* estimator : {"filter", "smoother"}) {
    for (const char* phase : {"rest", "under_way", "rest_after"}) {
      const YAML::Node found = json[estimator][phase];
      EXPECT_EQ(found["groups"].size(), report.groups.size());
      EXPECT_EQ(found["blocks"].size(), report.layout.blocks().size());
    }
  }
  const YAML::Node whole = json["filter"]["under_way"]["groups"]["whole"];
  EXPECT_EQ(whole["dof"].as<int>(), 21);
  EXPECT_NEAR(whole["nees"].as<double>(), report.filter.groups[1][0].nees, 1e-9);
  EXPECT_LT(whole["band"][0].as<double>(), 1);
  EXPECT_GT(whole["band"][1].as<double>(), 1);
  EXPECT_TRUE(whole["inside"].as<bool>());
  EXPECT_EQ(whole["coverage"].size(), 3U);
  EXPECT_GT(whole["largest_sigmas"].as<double>(), 3);
  const YAML::Node attitude = json["smoother"]["under_way"]["blocks"]["attitude"];
  EXPECT_EQ(attitude["unit"].as<std::string>(), "deg");
  EXPECT_NEAR(attitude["bound"].as<double>(), kDegreesPerRadian * 0.01 * std::sqrt(1.5), 1e-8);
  EXPECT_NEAR(attitude["ratio"].as<double>(), 1, 0.1);
  const YAML::Node nis = json["nis"]["attitude[0]"];
  EXPECT_EQ(nis["autocorrelation"].size(), 1U) << "an axis a row of the measurement";
  EXPECT_EQ(nis["count"].as<int>(), 20 * 401);
  EXPECT_EQ(json["heading_found"]["time_s"].as<double>(), 5);
  EXPECT_NEAR(json["heading_found"]["largest_sigma"].as<double>(), 0.01 * kDegreesPerRadian, 1e-8);
  const YAML::Node series = json["time_series"];
  EXPECT_EQ(series["time_s"].size(), 71U);
  EXPECT_EQ(series["filter"]["nees"]["biases"].size(), 71U);
  EXPECT_NEAR(series["filter"]["bound"]["velocity"][3].as<double>(), 0.05 * std::sqrt(3), 1e-6);
  EXPECT_EQ(text, consistency_json(report, "a \"ski\" run"));
}

TEST(ConsistencyJson, HasNullsWhereNothingWas) {
  const EpochGrid grid{.step = 1, .first = 0, .last = 4, .cruise = {1, 3}, .arrival = 4};
  Consistency sums(grid);
  ComparedRun run = test::drawn_run({.grid = grid}, 1);
  run.smoothed.clear();
  std::erase_if(run.filtered, [](const ErrorSample& s) { return s.epoch == 2; });
  run.innovations.clear();
  sums.add(run);
  sums.add_failure({18446744073709551615U, "data.csv:7: \"nan\"\n\\ is no number"});
  const std::string text = consistency_json(sums.report(), "");
  const YAML::Node json = YAML::Load(text);
  EXPECT_FALSE(json["consistent"].as<bool>());
  EXPECT_EQ(json["failures"][0]["seed"].as<std::uint64_t>(), 18446744073709551615U);
  EXPECT_EQ(json["failures"][0]["what"].as<std::string>(), "data.csv:7: \"nan\"\n\\ is no number");
  EXPECT_TRUE(json["phases"]["rest"].IsNull());
  EXPECT_TRUE(json["filter"]["rest"].IsNull());
  EXPECT_TRUE(json["filter"]["under_way"]["groups"]["whole"]["standard_error"].IsNull()) << "of one run";
  EXPECT_TRUE(json["smoother"]["under_way"].IsNull());
  EXPECT_TRUE(json["time_series"]["filter"]["nees"]["whole"][2].IsNull());
  EXPECT_TRUE(json["heading_found"].IsNull());
  EXPECT_EQ(json["nis"].size(), 0U);
  for (const char* wrong : {": nan", ", nan", "[nan", "inf"}) EXPECT_FALSE(contains(text, wrong)) << wrong;
}

TEST(ConsistencyRow, HasAsManyCellsAsItsHead) {
  const auto cells = [](std::string line) {
    for (std::size_t at; (at = line.find("\\|")) != std::string::npos;) line.erase(at, 2);
    return std::count(line.begin(), line.end(), '|');
  };
  const auto head = lines(consistency_row_head());
  ASSERT_EQ(head.size(), 2U);
  EXPECT_EQ(cells(head[0]), cells(head[1]));
  const auto row = lines(consistency_row(added({.runs = 3}).report(), "ski | L1\nagain"));
  ASSERT_EQ(row.size(), 1U);
  EXPECT_EQ(cells(row[0]), cells(head[0]));
  for (const char* part : {"ski \\| L1", "0 of 22", "gnss[0].position 0.975, ", " sigma  "})
    EXPECT_TRUE(contains(row[0], part)) << row[0];
  ComparedRun bare = test::drawn_run({}, 1);
  bare.smoothed.clear();
  bare.filtered.resize(3);
  bare.innovations.clear();
  Consistency sums(Ensemble{}.grid);
  sums.add(bare);
  EXPECT_EQ(cells(lines(consistency_row(sums.report(), "bare")).front()), cells(head[0]));
}

TEST(ConsistencyText, BeginsWithTheVerdict) {
  const std::string good = consistency_text(added({.runs = 20}).report());
  EXPECT_TRUE(good.starts_with("Consistent: over 20 runs")) << good;
  for (const char* wrong : {"*", " \n"}) EXPECT_EQ(good.find(wrong), std::string::npos) << good;
  for (const char* part : {"whole", "accel_scale", "attitude", "gnss[0].position", "Heading 5 s"}) {
    EXPECT_TRUE(contains(good, part)) << part;
  }
  Consistency sums = added({.runs = 9, .claimed = 0.5, .whiteness = 0.3});
  sums.add_failure({4, "lost"});
  const std::string bad = consistency_text(sums.report());
  EXPECT_TRUE(bad.starts_with("Not consistent: over 9 runs, under way, the NEES of filter whole, filter ")) << bad;
  EXPECT_TRUE(contains(lines(bad).front(), "; 1 of 10 runs failed.")) << bad;
  EXPECT_TRUE(contains(bad, "*, band ±")) << bad;
}

}  // namespace
}  // namespace piste
