// What the pages name is there: programs, scripts, configurations, files and tests.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "support/ctest_list.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

/// Something that a page names.
struct Named {
  fs::path page;
  std::string what;
};

std::vector<fs::path> pages() {
  std::vector<fs::path> all{kSource / "README.md", kSource / "CONTRIBUTING.md", kSource / "CHANGELOG.md"};
  for (const auto& entry : fs::directory_iterator(kSource / "docs")) {
    if (entry.path().extension() == ".md") all.push_back(entry.path());
  }
  return all;
}

/// The first group of every match of a pattern in the pages.
std::vector<Named> named(const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<Named> all;
  for (const fs::path& page : pages()) {
    const std::string text = read_text(page);
    for (std::sregex_iterator match(text.begin(), text.end(), regex), end; match != end; ++match) {
      all.push_back({page, (*match)[1].str()});
    }
  }
  return all;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Docs, NameProgramsThatAreBuilt) {
  const std::vector<std::string> built = lines_of(read_text(fs::path(build_folder()) / "programs.txt"));
  const std::vector<Named> programs = named("build/release/([a-z_]+/[a-z0-9_]+)");
  EXPECT_GE(programs.size(), 10U);
  for (const auto& [page, program] : programs) {
    const std::string folder = program.substr(0, program.find('/')), name = program.substr(folder.size() + 1);
    const bool configured = std::any_of(built.begin(), built.end(),
                                        [&](const std::string& file) { return file.starts_with(folder + "/"); });
    if (configured) {
      EXPECT_NE(std::find(built.begin(), built.end(), program), built.end()) << page << " names " << program;
    } else {  // benchmarks, where they are not asked for
      EXPECT_TRUE(contains(read_text(kSource / folder / "CMakeLists.txt"), "add_executable(" + name + " ")) << page;
    }
  }
}

TEST(Docs, NameFilesThatExist) {
  const std::vector<Named> files =
      named("(?:^|[^A-Za-z0-9_./-])((?:\\.ci|config|data|docs|include|scripts)/[A-Za-z0-9_./-]*[A-Za-z0-9_])");
  EXPECT_GE(files.size(), 20U);
  for (const auto& [page, file] : files) EXPECT_TRUE(fs::exists(kSource / file)) << page << " names " << file;
}

TEST(Docs, LinkToFilesThatExist) {
  const std::vector<Named> links = named("\\]\\(([^):#]+)");
  EXPECT_GE(links.size(), 10U);
  for (const auto& [page, link] : links) {
    EXPECT_TRUE(fs::exists(page.parent_path() / link)) << page << " links to " << link;
  }
}

/// The paths of all keys below a node, such as `imu.clock.offset`; those of a list count as one. What is below
/// `columns` has a page of its own.
void append_keys(const YAML::Node& node, const std::string& path, std::vector<std::string>& keys) {
  for (const auto& item : node) {
    if (node.IsSequence()) {
      if (item.IsMap()) append_keys(item, path, keys);
      continue;
    }
    const auto key = path + item.first.as<std::string>();
    keys.push_back(key);
    const bool named_by_others =
        key.ends_with("columns") || key.ends_with("article_sensors") || key.ends_with("output.at");
    if (!named_by_others && (item.second.IsMap() || item.second.IsSequence())) {
      append_keys(item.second, key + ".", keys);
    }
  }
}

/// A block may show a part of a configuration: its keys then are the ends of whole ones.
TEST(Docs, ShowKeysThatAreRead) {
  std::vector<std::string> known;
  for (const Named& row : named("\\n\\| `([a-z_.]+)` \\|")) {
    if (row.page.filename() == "keys.md") known.push_back("." + row.what);
  }
  EXPECT_GE(known.size(), 200U);
  std::size_t shown = 0;
  for (const auto& [page, block] : named("```yaml\n([^`]*(?:`[^`]+`[^`]*)*)```")) {
    YAML::Node yaml;
    EXPECT_NO_THROW(yaml = YAML::Load(block)) << page << ":\n" << block;
    std::vector<std::string> keys;
    append_keys(yaml, ".", keys);
    for (std::string key : keys) {
      ++shown;
      key = std::regex_replace(key, std::regex("^\\.(runs\\.)?(mems|reference)\\."), ".imu.");  // the same keys
      key = std::regex_replace(key, std::regex("^\\.runs\\.gnss\\."), ".gnss.");
      EXPECT_TRUE(std::any_of(known.begin(), known.end(), [&](const std::string& k) { return k.ends_with(key); }))
          << page << " shows the key " << key.substr(1);
    }
  }
  EXPECT_GE(shown, 100U);
}

TEST(Docs, NameTestsThatExist) {
  const std::string list = ctest_list();
  if (list.find("_NOT_BUILT") != std::string::npos)
    GTEST_SKIP() << "build every test first: ctest does not know them all";
  const std::vector<std::string> all = lines_of(list);
  const std::vector<Named> patterns = named("ctest --test-dir build/release[^`\n]* -R ([^ `\n]+)");
  EXPECT_GE(patterns.size(), 3U);
  for (const auto& [page, pattern] : patterns) {
    const std::regex regex(pattern);
    EXPECT_TRUE(
        std::any_of(all.begin(), all.end(), [&](const std::string& line) { return std::regex_search(line, regex); }))
        << page << " names the tests " << pattern;
  }
}

}  // namespace
}  // namespace piste::test
