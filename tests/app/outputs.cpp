// Outputs are whole or absent: where the disk is full, the folder cannot be written, the program is killed.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <regex>
#include <set>

#include "piste/files/output.h"
#include "support/places.h"
#include "support/random.h"
#include "support/ski_run.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

const std::string kFilesOf100kB = "ulimit -f 200";    // blocks of 512 bytes; who writes more is killed,
const std::string kNotKilled = " && trap \"\" XFSZ";  // or told so, as by a full disk

/// The files in a folder and below, hidden ones as well.
std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[std::filesystem::relative(entry, folder).string()] = read_text(entry);
  }
  return files;
}

bool is_partial(const std::string& name) { return name.ends_with(".partial"); }

std::size_t partial_files(const std::map<std::string, std::string>& files) {
  return static_cast<std::size_t>(
      std::count_if(files.begin(), files.end(), [](const auto& file) { return is_partial(file.first); }));
}

class Outputs : public ::testing::Test {
 protected:
  Said replay(const std::string& first = "true", const std::string& output = "result") const {
    return run_program(program("replay"), {SkiRun::kConfig, "--output", output, "--quiet"}, run_.folder, first);
  }
  std::map<std::string, std::string> results() const { return files_in(run_.folder / "result"); }

  SkiRun run_;
};

TEST_F(Outputs, AFullDiskLeavesNothing) {
  const Said said = replay(kFilesOf100kB + kNotKilled);
  EXPECT_EQ(said.code, 1);
  EXPECT_TRUE(contains(said.err, "result/filtered.csv: cannot be written; is the disk full"));
  EXPECT_FALSE(std::filesystem::exists(run_.folder / "result"));
}

TEST_F(Outputs, AFullDiskLeavesTheRunBefore) {
  ASSERT_EQ(replay().code, 0);
  const auto before = results();
  EXPECT_EQ(replay(kFilesOf100kB + kNotKilled).code, 1);
  EXPECT_EQ(results(), before);
}

TEST_F(Outputs, AFolderThatCannotBeWritten) {
  const Said inside = replay("true", "/proc/self/task");
  EXPECT_EQ(inside.code, 1);
  EXPECT_TRUE(contains(inside.err, "/proc/self/task/filtered.csv: cannot be written"));
  const Said made = replay("true", "/proc/piste");
  EXPECT_EQ(made.code, 2);
  EXPECT_TRUE(contains(made.err, "/proc/piste: cannot be made"));
  const Said file = replay("true", SkiRun::kConfig);
  EXPECT_EQ(file.code, 2);
  EXPECT_TRUE(contains(file.err, "ski_run.yaml: is no folder; choose another --output"));
}

TEST_F(Outputs, AKilledRunLeavesNoneAndTheNextOneCleans) {
  EXPECT_FALSE(std::set<int>({0, 1, 2}).contains(replay(kFilesOf100kB).code));
  EXPECT_EQ(partial_files(results()), results().size());
  EXPECT_GE(results().size(), 1u) << "it was not killed while it wrote";

  run_.write("result/.of_another_run.csv.piste.partial", "cut");
  run_.write("result/notes.partial", "of somebody else");
  ASSERT_EQ(replay().code, 0);
  const auto whole = results();
  EXPECT_EQ(partial_files(whole), 1u);
  EXPECT_EQ(whole.at("notes.partial"), "of somebody else");
  for (const char* name : {"filtered.csv", "smoothed.csv", "summary.json", "report.html"}) {
    EXPECT_TRUE(whole.contains(name)) << name;
  }

  EXPECT_FALSE(std::set<int>({0, 1, 2}).contains(replay(kFilesOf100kB).code));
  auto after = results();
  std::erase_if(after, [](const auto& file) { return file.first.ends_with(".piste.partial"); });
  EXPECT_EQ(after, whole) << "the run before";
}

// Two configurations of one run, of which each writes other bytes into the same files.
class OutputsAtAnyInstant : public Outputs {
 protected:
  using Files = std::map<std::string, std::string>;

  // What is there, but for partial files and the times that a run took.
  Files whole_results() const {
    static const std::regex took(R"re("(cpu_s|wall_s)": [^,}]*)re");
    Files files = results();
    std::erase_if(files, [](const auto& file) { return is_partial(file.first); });
    if (auto& summary = files["summary.json"]; !summary.empty()) summary = std::regex_replace(summary, took, "");
    std::erase_if(files, [](const auto& file) { return file.second.empty(); });
    return files;
  }

  OutputsAtAnyInstant() {
    run_.write(kOther, run_.text(SkiRun::kConfig) + "output: {rate: 7 Hz}\n");
    one_ = whole(SkiRun::kConfig);
    const auto begin = std::chrono::steady_clock::now();
    other_ = whole(kOther);
    takes_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  // A shell's commands in the run's folder.
  int shell(const std::string& commands) const {
    return std::system(fmt::format("cd '{}' && {{ {} ; }}", run_.folder.path().string(), commands).c_str());
  }
  static std::string started(const std::string& config, const std::string& log) {
    return fmt::format("'{}' {} --output result --quiet >{} 2>&1", program("replay"), config, log);
  }
  Files whole(const std::string& config) const {
    EXPECT_EQ(shell(started(config, ".log")), 0);
    EXPECT_EQ(partial_files(results()), 0u);
    return whole_results();
  }

  static constexpr const char* kOther = "config/other.yaml";
  Files one_, other_;
  double takes_ = 0;
};

TEST_F(OutputsAtAnyInstant, Killed) {
  ASSERT_NE(one_, other_);
  Random random(3);
  int undisturbed = 0, cases = seeds(3, 50);
  for (int i = 0; i < cases; ++i) {
    ASSERT_EQ(whole(SkiRun::kConfig), one_);
    const double instant = i == 0 ? 0.01 : 1.2 * takes_ * random.uniform();  // the first is surely in time
    shell(fmt::format("{} & sleep {:.4f}; kill -KILL $!; wait", started(kOther, ".log"), instant));
    Files left = whole_results();
    // All are of one run where the file that is written last is there.
    if (left.contains("summary.json")) {
      EXPECT_TRUE(left == one_ || left == other_) << instant;
      undisturbed += left == one_ ? 1 : 0;
    }
    for (const auto& [name, text] : left) EXPECT_TRUE(text == one_[name] || text == other_[name]) << name << instant;
  }
  EXPECT_GT(undisturbed, 0);
  EXPECT_EQ(whole(kOther), other_);
}

TEST_F(OutputsAtAnyInstant, DiskFull) {
  std::size_t largest = 0;
  for (const auto& [name, text] : other_) largest = std::max(largest, text.size());
  Random random(4);
  ASSERT_EQ(whole(SkiRun::kConfig), one_);
  for (int i = 0, cases = seeds(3, 50); i < cases; ++i) {
    const auto blocks = static_cast<int>(static_cast<double>(largest) / 512 * random.uniform());
    const Said said = run_program(program("replay"), {kOther, "--output", "result", "--quiet"}, run_.folder,
                                  fmt::format("ulimit -f {}", blocks) + kNotKilled);
    EXPECT_EQ(said.code, 1) << blocks;
    // So little room that the message itself has none.
    EXPECT_TRUE(contains(said.err, "is the disk full") || blocks == 0) << said.err;
    EXPECT_EQ(whole_results(), one_) << blocks;
    EXPECT_EQ(partial_files(results()), 0u);
  }
}

TEST_F(OutputsAtAnyInstant, TwoProgramsInOneFolder) {
  Random random(5);
  for (int i = 0, cases = seeds(3, 50); i < cases; ++i) {
    const double instant = takes_ * random.uniform();
    EXPECT_EQ(shell(fmt::format("{} & sleep {:.4f}; {} && wait $!", started(SkiRun::kConfig, ".one"), instant,
                                started(kOther, ".other"))),
              0)
        << instant << run_.text(".one") << run_.text(".other");
    const Files left = whole_results();
    EXPECT_EQ(partial_files(results()), 0u);
    EXPECT_TRUE(left == one_ || left == other_) << instant;
  }
}

TEST(OutputFolder, WhatIsWrittenLastStandsForTheWholeRun) {
  const TemporaryFolder folder;
  const auto write = [&](OutputFolder& output, const std::string& text) {
    for (const char* name : {"a.csv", "sub/b.csv", "summary.json"}) output.write(name, text);
  };
  {
    OutputFolder output(folder.path());
    write(output, "first");
    output.commit();
  }
  EXPECT_EQ(files_in(folder.path()).size(), 3u);
  {
    OutputFolder output(folder.path());
    write(output, "second");
    EXPECT_EQ(read_text(folder / "summary.json"), "first");
    std::filesystem::remove(output.partial("sub/b.csv"));  // ends the commit half way, as a kill would
    EXPECT_THROW(output.commit(), std::filesystem::filesystem_error);
  }
  const std::map<std::string, std::string> mixed{{"a.csv", "second"}, {"sub/b.csv", "first"}};
  EXPECT_EQ(files_in(folder.path()), mixed);
}

TEST(OutputFolder, TwoOfOneFolderLeaveEachOtherAlone) {
  const TemporaryFolder folder;
  {
    OutputFolder one(folder.path()), other(folder.path());
    one.write("a.csv", "one");
    one.write("sub/b.csv", "one");
    other.write("a.csv", "other");
    other.commit();  // removes what nobody owns, and none of the files of `one`
    EXPECT_EQ(read_text(folder / "a.csv"), "other");
    one.commit();
  }
  const std::map<std::string, std::string> whole{{"a.csv", "one"}, {"sub/b.csv", "one"}};
  EXPECT_EQ(files_in(folder.path()), whole);
}

}  // namespace
}  // namespace piste::test
