// `montecarlo` as its user sees it: what it writes, says and returns, whatever the jobs and however often it was
// stopped.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "support/places.h"
#include "support/program.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

// A few seconds of the bicycle lap.
std::string tiny_scenario(const TemporaryFolder& folder, const std::string& more = "") {
  return folder.write("tiny.yaml", fmt::format("base: {}/config/scenarios/bicycle.yaml\n"
                                               "motion: {{rest_before: 2 s, run: 13 s, rest_after: 1 s}}\n{}",
                                               source_folder(), more));
}

Said montecarlo(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.begin(), folder / "tiny.yaml");
  return run_program(program("montecarlo"), words, folder);
}

TEST(Montecarlo, WritesWhatItFound) {
  const TemporaryFolder folder;
  tiny_scenario(folder);
  const Said said = montecarlo(folder, {"--runs", "3", "--output", "a"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "NEES"));
  EXPECT_TRUE(contains(said.out, "written to a"));
  const YAML::Node json = YAML::LoadFile(folder / "a/consistency.json");
  EXPECT_EQ(json["runs"].as<int>(), 3);
  EXPECT_TRUE(contains(read_text(folder / "a/consistency.html"), "</html>"));
  EXPECT_TRUE(contains(read_text(folder / "a/consistency.md"), "| tiny "));
  for (const auto& entry : fs::recursive_directory_iterator(folder.path() / "a")) {
    EXPECT_FALSE(entry.path().filename().string().ends_with(".partial")) << entry.path();
  }
}

TEST(Montecarlo, SameBytesWhateverTheJobsAndTheStops) {
  const TemporaryFolder folder;
  tiny_scenario(folder);
  ASSERT_EQ(montecarlo(folder, {"--runs", "4", "--jobs", "1", "--output", "a"}).code, 0);
  ASSERT_EQ(montecarlo(folder, {"--runs", "4", "--jobs", "3", "--output", "b"}).code, 0);
  ASSERT_EQ(montecarlo(folder, {"--runs", "2", "--output", "c"}).code, 0);
  const Said on = montecarlo(folder, {"--runs", "4", "--output", "c"});
  ASSERT_EQ(on.code, 0);
  EXPECT_TRUE(contains(on.out, "going on after 2 runs"));
  for (const char* name : {"consistency.json", "consistency.html", "consistency.md", "ensemble.state"}) {
    const std::string one = read_text(folder.path() / "a" / name);
    EXPECT_FALSE(one.empty());
    EXPECT_EQ(one, read_text(folder.path() / "b" / name)) << name;
    EXPECT_EQ(one, read_text(folder.path() / "c" / name)) << name;
  }
}

TEST(Montecarlo, PartsMergeToTheBytesOfTheWhole) {
  const TemporaryFolder folder;
  tiny_scenario(folder);
  ASSERT_EQ(montecarlo(folder, {"--runs", "5", "--output", "whole"}).code, 0);
  const Said part = montecarlo(folder, {"--runs", "3", "--sums", "0.sums"});
  ASSERT_EQ(part.code, 0) << part.err;
  EXPECT_TRUE(contains(part.out, "runs 0 to 2 in "));
  ASSERT_EQ(montecarlo(folder, {"--first", "3", "--runs", "1", "--sums", "3.sums"}).code, 0);
  ASSERT_EQ(montecarlo(folder, {"--first", "3", "--runs", "2", "--sums", "3.sums"}).code, 0);  // goes on
  const Said merged = montecarlo(folder, {"0.sums", "3.sums", "--output", "merged"});
  ASSERT_EQ(merged.code, 0) << merged.err;
  for (const char* name : {"consistency.json", "consistency.html", "consistency.md", "ensemble.state"}) {
    EXPECT_EQ(read_text(folder.path() / "whole" / name), read_text(folder.path() / "merged" / name)) << name;
  }
  EXPECT_FALSE(fs::exists(folder / "out"));

  const Said other_order = montecarlo(folder, {"3.sums", "0.sums", "--output", "b"});
  EXPECT_EQ(other_order.code, 1);
  EXPECT_TRUE(contains(other_order.err, "3.sums: ")) << other_order.err;
  EXPECT_TRUE(contains(other_order.err, "no run is there; the next part must begin with run 0, and not 3"))
      << other_order.err;
  EXPECT_EQ(montecarlo(folder, {"0.sums", "--sums", "c.sums"}).code, 2);
  EXPECT_EQ(montecarlo(folder, {"missing.sums", "--output", "b"}).code, 2);
  EXPECT_EQ(montecarlo(folder, {"--first", "3", "--output", "b"}).code, 2);
  folder.write("cut.sums", read_text(folder / "0.sums").substr(0, 1000));
  EXPECT_EQ(montecarlo(folder, {"cut.sums", "--output", "b"}).code, 1);
}

TEST(Montecarlo, GoesOnAfterItWasKilled) {
  const TemporaryFolder folder;
  tiny_scenario(folder);
  // Kills the program once a command of the shell succeeds, or after two minutes.
  const auto run_and_kill_when = [&](const std::string& done) {
    const std::string command = fmt::format(
        "cd '{}' && {{ '{}' tiny.yaml --runs 100000 --output a >.out 2>.err & }} && "
        "for i in $(seq 1200); do if {}; then break; fi; sleep 0.1; done; kill -KILL $!; wait $!",
        folder.path().string(), program("montecarlo"), done);
    EXPECT_NE(std::system(command.c_str()), 0);
  };
  run_and_kill_when("[ -e a/ensemble.state ]");
  ASSERT_TRUE(fs::exists(folder / "a/ensemble.state"));
  EXPECT_FALSE(fs::exists(folder / "a/consistency.json"));
  run_and_kill_when("grep -q 'going on after' .out");
  EXPECT_TRUE(contains(read_text(folder / ".out"), "going on after"));
}

TEST(Montecarlo, StartsAnewWhereTheScenarioChanged) {
  const TemporaryFolder folder;
  tiny_scenario(folder);
  ASSERT_EQ(montecarlo(folder, {"--runs", "2", "--output", "a"}).code, 0);
  tiny_scenario(folder, "montecarlo: {heading: auto}\n");
  const Said said = montecarlo(folder, {"--runs", "2", "--output", "a"});
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "starting anew"));
}

TEST(Montecarlo, DoesNotThrowRunsAway) {
  const TemporaryFolder folder;
  tiny_scenario(folder);
  ASSERT_EQ(montecarlo(folder, {"--runs", "3", "--output", "a"}).code, 0);
  const std::string three = read_text(folder / "a/ensemble.state");
  const Said fewer = montecarlo(folder, {"--runs", "2", "--output", "a"});
  EXPECT_EQ(fewer.code, 2);
  EXPECT_TRUE(contains(fewer.err, "ensemble.state holds 3 runs of this scenario already")) << fewer.err;
  EXPECT_EQ(read_text(folder / "a/ensemble.state"), three);
}

TEST(Montecarlo, RefusesWithFileAndLine) {
  const TemporaryFolder folder;
  tiny_scenario(folder, "montecarlo: {gnss: gnss_l5}\n");
  Said said = montecarlo(folder, {"--runs", "1"});
  EXPECT_EQ(said.code, 2);
  EXPECT_TRUE(contains(said.err, "tiny.yaml:3: "));
  EXPECT_TRUE(contains(said.err, "gnss_l1l2"));
  EXPECT_EQ(montecarlo(folder, {"--runs", "0"}).code, 2);
  EXPECT_EQ(montecarlo(folder, {"--jobs", "0"}).code, 2);
  EXPECT_EQ(run_program(program("montecarlo"), {"absent.yaml"}, folder).code, 2);
  EXPECT_EQ(run_program(program("montecarlo"), {}, folder).code, 2);
}

TEST(Montecarlo, SaysWhyNoRunCouldBeReplayed) {
  const TemporaryFolder folder;
  tiny_scenario(folder, "montecarlo: {heading: auto, outages: [[-2 s, 15.9 s]]}\n");
  const Said said = montecarlo(folder, {"--runs", "2", "--output", "a"});
  EXPECT_EQ(said.code, 1);
  EXPECT_TRUE(contains(said.err, "no run could be replayed"));
  EXPECT_TRUE(contains(said.err, "GNSS"));
  EXPECT_FALSE(fs::exists(folder / "a/consistency.json"));
}

}  // namespace
}  // namespace piste::test
