// What all programs promise together, and members of their files that no other test looks at.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <set>

#include "support/navigation.h"
#include "support/places.h"
#include "support/ski_run.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

/// The programs of this build.
std::vector<std::string> programs() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(program("replay")).parent_path())) {
    const bool runs = (entry.status().permissions() & fs::perms::owner_exec) != fs::perms::none;
    if (entry.is_regular_file() && runs && !entry.path().has_extension())
      names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST(Contracts, EveryProgramKnowsItsCommandLine) {
  const std::vector<std::string> names = programs();
  EXPECT_GE(names.size(), 12U);
  const TemporaryFolder folder;
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const Said help = run_program(program(name), {"--help"}, folder);
    EXPECT_EQ(help.code, 0);
    EXPECT_EQ(help.err, "");
    for (const char* option : {"--output", "--quiet", "--help"}) EXPECT_TRUE(contains(help.out, option));
    // A newer CLI11, as Debian 13 has it, takes no other name of what is not an option than one word.
    EXPECT_TRUE(std::regex_search(help.out, std::regex("Usage: [a-z]+ \\[OPTIONS\\] [A-Z]+(\\.\\.\\.)?\n")))
        << help.out;
    const std::vector<std::vector<std::string>> wrong{{}, {"a.yaml", "--ouput", "x"}};
    for (const auto& words : wrong) {
      const Said said = run_program(program(name), words, folder);
      EXPECT_EQ(said.code, 2);
      EXPECT_EQ(said.out, "");
      EXPECT_NE(said.err, "");
    }
  }
}

// summary.json, terminal and page have the same warnings.
TEST(Contracts, WarningsAreTheSameEverywhere) {
  const SkiRun run;
  run.replace(SkiRun::kConfig, "-0.06 0.03 -0.42 m", "-60 30 -420 m");
  const Said said = run.replay();
  ASSERT_EQ(said.code, 0);
  const YAML::Node warnings = YAML::Load(run.text("result/summary.json"))["warnings"];
  ASSERT_GE(warnings.size(), 1U);
  std::size_t shown = 0;
  for (auto at = said.err.find("warning: "); at != std::string::npos; at = said.err.find("warning: ", at + 1)) ++shown;
  EXPECT_EQ(warnings.size(), shown) << said.err;
  const std::string page = run.text("result/report.html");
  for (const YAML::Node& warning : warnings) {
    const auto text = warning.as<std::string>();
    EXPECT_TRUE(contains(said.err, "warning: " + text)) << said.err;
    EXPECT_TRUE(contains(page, text.substr(0, text.find_first_of("<>&'\"")))) << text;
  }
}

// 18 leap seconds lie between GPS time and UTC in week 2200, which began 1646524800 s after 1970 by GPS time.
TEST(Contracts, TimesOfARowAreOneInstant) {
  const SkiRun run;
  const std::string config = run.text(SkiRun::kConfig);
  const auto replayed = [&](const std::string& time) {
    run.write(SkiRun::kConfig, config + "\nweek: 2200\noutput: {time: " + time + "}\n");
    const Said said = run.replay();
    EXPECT_EQ(said.code, 0) << said.err;
    return read_table(run.folder / "result/smoothed.csv");
  };
  const Table seconds = replayed("unix"), weeks = replayed("gps_week");
  ASSERT_EQ(seconds.rows, weeks.rows);
  ASSERT_GT(seconds.rows, 5000U);
  for (std::size_t i = 0; i < seconds.rows; i += 100) {
    EXPECT_NEAR(seconds["time_unix_s"][i], 1646524800 + seconds["time_s"][i] - 18, 2e-6);
    EXPECT_EQ(weeks["gps_week"][i], 2200);
  }
}

void expect_members(const YAML::Node& node, const std::set<std::string>& wanted, const char* of) {
  std::set<std::string> names;
  for (const auto& member : node) names.insert(member.first.as<std::string>());
  EXPECT_TRUE(std::ranges::includes(names, wanted)) << of;
}

TEST(Contracts, EvaluationHasItsMembers) {
  const SkiRun run;
  ASSERT_EQ(run.replay().code, 0);
  const Said said = run_program(
      program("evaluate"),
      {"result", kSource / "data/ski_run/truth.csv", "--align", "sim3", "--rpe", "50m", "--output", "judged"},
      run.folder);
  ASSERT_EQ(said.code, 0) << said.err;
  const YAML::Node found = YAML::Load(run.text("judged/evaluation.json"));
  expect_members(found, {"epochs", "align", "ape", "rpe", "within_sigma"}, "evaluation.json");
  expect_members(found["align"], {"kind", "rotation", "translation_m", "scale"}, "align");
  const std::set<std::string> statistics{"rmse_m", "mean_m", "median_m", "std_m", "min_m", "max_m", "rotation"};
  const std::set<std::string> angles{"rmse_deg", "mean_deg", "median_deg", "std_deg", "min_deg", "max_deg"};
  expect_members(found["ape"], statistics, "ape");
  expect_members(found["ape"], {"cep50_m", "cep95_m"}, "ape");
  expect_members(found["ape"]["rotation"], angles, "ape.rotation");
  expect_members(found["rpe"]["50 m"], statistics, "rpe");
  expect_members(found["rpe"]["50 m"], {"pairs"}, "rpe");
  EXPECT_LE(found["ape"]["cep50_m"].as<double>(), found["ape"]["cep95_m"].as<double>());
  EXPECT_NEAR(found["align"]["scale"].as<double>(), 1, 1e-3);
  expect_members(found["within_sigma"],
                 {"north_m", "east_m", "down_m", "velocity_north_m_s", "velocity_east_m_s", "velocity_down_m_s",
                  "roll_deg", "pitch_deg", "heading_deg"},
                 "within_sigma");
  for (const auto& shares : found["within_sigma"]) {
    ASSERT_EQ(shares.second.size(), 3U);
    EXPECT_LE(shares.second[0].as<double>(), shares.second[1].as<double>());
    EXPECT_LE(shares.second[1].as<double>(), shares.second[2].as<double>());
  }
}

TEST(Contracts, ExportsOfDatesNeedAWeek) {
  const SkiRun run;
  ASSERT_EQ(run.replay().code, 0);
  for (const char* format : {"gpx", "geojson", "nmea", "rtklib"}) {
    const Said said = run_program(program("export"), {"result", "--to", format, "--output", "file"}, run.folder);
    EXPECT_EQ(said.code, 1) << format;
    EXPECT_TRUE(contains(said.err, "week")) << said.err;
    EXPECT_FALSE(fs::exists(run.folder / "file")) << format;
    const Said dated =
        run_program(program("export"), {"result", "--to", format, "--week", "2200", "--output", "file"}, run.folder);
    EXPECT_EQ(dated.code, 0) << dated.err;
    EXPECT_TRUE(fs::remove(run.folder / "file")) << format;
  }
}

}  // namespace
}  // namespace piste::test
