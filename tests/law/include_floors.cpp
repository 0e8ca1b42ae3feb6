// A folder includes only folders on lower floors, or itself.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/places.h"

namespace {

namespace fs = std::filesystem;

const std::map<std::string, int> kFloors = {
    {"math", 1},        {"core", 2},       {"model", 3},     {"io", 3},       {"condition", 3},   {"plot", 3},
    {"columns", 4},     {"allan", 4},      {"fit", 4},       {"walker", 4},   {"consistency", 4}, {"configuration", 4},
    {"filter", 5},      {"trajectory", 5}, {"sim", 5},       {"smoother", 6}, {"start", 7},       {"live", 8},
    {"inspect", 8},     {"tune", 8},       {"align", 8},     {"batch", 8},    {"replay", 9},      {"diagnosis", 9},
    {"trial", 10},      {"study", 10},     {"evaluate", 10}, {"points", 10},  {"descents", 11},   {"search", 10},
    {"recordings", 11}, {"exports", 12},   {"files", 12},    {"report", 12},  {"outputs", 13},    {"piste.h", 14},
    {"batch.h", 14},    {"apps", 15}};

/// First part of `model/imu_errors.h`.
std::string folder_of(const std::string& path) { return path.substr(0, path.find('/')); }

/// What is wrong with `text`, a file that stands in `folder`: one line an include that goes up or sideways.
std::vector<std::string> violations(const std::string& folder, const std::string& text) {
  static const std::regex include(R"(^\s*#\s*include\s*["<]([^">]+)[">])", std::regex::multiline);
  std::vector<std::string> wrong;
  for (std::sregex_iterator match(text.begin(), text.end(), include), end; match != end; ++match) {
    const std::string path = (*match)[1];
    const bool ours = path.starts_with("piste/");
    const std::string target = folder_of(ours ? path.substr(6) : path);
    if (target == "..") wrong.push_back(path + ": name the folder, not the way to it");
    const auto floor = kFloors.find(target);
    if (floor == kFloors.end()) {
      if (ours) wrong.push_back(path + ": a folder without a floor");
    } else if (target != folder && floor->second >= kFloors.at(folder)) {
      wrong.push_back(path + ": included from " + folder + ", which is not above it");
    }
  }
  return wrong;
}

std::string read(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(IncludeFloors, EveryIncludeGoesDown) {
  const fs::path source = piste::test::source_folder();
  int files = 0;
  for (const fs::path& root : {source / "include/piste", source / "src", source / "apps"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      const bool app = root.filename() == "apps";
      const std::string folder = app ? "apps" : folder_of(fs::relative(entry.path(), root).generic_string());
      ASSERT_TRUE(kFloors.contains(folder)) << entry.path() << " stands in a folder without a floor";
      for (const auto& wrong : violations(folder, read(entry.path()))) ADD_FAILURE() << entry.path() << ": " << wrong;
    }
  }
  EXPECT_GE(files, 10);
}

// The page that explains the house has the same floors.
TEST(IncludeFloors, TheHouseIsAsItsPageSays) {
  const std::string page = read(fs::path(piste::test::source_folder()) / "docs/house.md");
  static const std::regex row(R"(\| (\d+) \| `([a-z.]+)` \|)");
  std::map<std::string, int> told;
  for (std::sregex_iterator match(page.begin(), page.end(), row), end; match != end; ++match) {
    told[(*match)[2]] = std::stoi((*match)[1]);
  }
  EXPECT_EQ(told, kFloors);
}

// What is installed is what a user calls: the front doors, and what they include. The rest stands in src.
TEST(IncludeFloors, EveryPublicHeaderIsReachedFromAFrontDoor) {
  static const std::regex include(R"re(^#include "(piste/[a-z_0-9/]+\.h)")re", std::regex::multiline);
  const fs::path root = fs::path(piste::test::source_folder()) / "include";
  std::set<std::string> reached;
  std::vector<std::string> next{"piste/piste.h", "piste/batch.h"};
  while (!next.empty()) {
    const std::string header = next.back();
    next.pop_back();
    if (!reached.insert(header).second) continue;
    const std::string text = read(root / header);
    for (std::sregex_iterator match(text.begin(), text.end(), include), end; match != end; ++match) {
      next.push_back((*match)[1]);
    }
  }
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() != ".h") continue;
    const std::string header = fs::relative(entry.path(), root).generic_string();
    EXPECT_TRUE(reached.contains(header)) << header << " is included by no front door: it belongs into src";
  }
}

// A room that grows beyond this holds more than one thing.
TEST(IncludeFloors, NoRoomHoldsMoreThan12PerCentOfTheLines) {
  const fs::path source = piste::test::source_folder();
  std::map<std::string, double> lines;
  double all = 0;
  for (const fs::path& root : {source / "include/piste", source / "src", source / "apps"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      const bool app = root.filename() == "apps";
      const std::string text = read(entry.path());
      const auto count = static_cast<double>(std::count(text.begin(), text.end(), '\n'));
      lines[app ? "apps" : folder_of(fs::relative(entry.path(), root).generic_string())] += count;
      all += count;
    }
  }
  ASSERT_GT(all, 10000);
  for (const auto& [room, count] : lines) EXPECT_LE(count / all, 0.12) << room << ": " << count << " lines of " << all;
}

TEST(IncludeFloors, CatchesWhatIsWrong) {
  EXPECT_EQ(
      violations("core", "#include <vector>\n#include \"piste/math/so3.h\"\n#include \"piste/core/log.h\"\n").size(),
      0U);
  EXPECT_EQ(violations("core", "#include <vector>\n#include \"piste/filter/filter.h\"\n").size(), 1U) << "upward";
  EXPECT_EQ(violations("model", "#include \"piste/io/csv.h\"\n").size(), 1U) << "sideways";
  EXPECT_EQ(violations("report", "  #  include <piste/piste.h>\n").size(), 1U) << "the front door from inside";
  EXPECT_EQ(violations("math", "#include \"piste/attic/box.h\"\n").size(), 1U) << "unknown folder";
  EXPECT_EQ(violations("filter", "#include \"../core/log.h\"\n#include \"report/charts.h\"\n").size(), 2U)
      << "private ways";
}

}  // namespace
