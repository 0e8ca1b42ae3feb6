// docs/keys.md holds every key of every configuration. What stands there of a key, but for the last column, is what the
// readers ask for: they are run on the configurations in tests/law/keys, and their Config tells what was asked. With
// PISTE_WRITE_KEYS in the environment (scripts/keys) the page is written anew; the last column stays.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "piste/align/align_config.h"
#include "piste/configuration/replay_config.h"
#include "piste/configuration/sensor_file.h"
#include "piste/recordings/allan.h"
#include "piste/sim/campaign.h"
#include "piste/sim/scenario.h"
#include "piste/study/study_config.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

/// A kind of configuration: how the page calls it, how the names of its files in tests/law/keys begin, and its reader.
struct Kind {
  std::string title, files;
  std::function<void(const Config&)> read;
};

std::vector<Kind> kinds() {
  return {{"replay, tune", "replay_", [](const Config& c) { read_replay_config(c); }},
          {"allan", "allan", [](const Config& c) { read_allan_config(c); }},
          {"sensor files", "sensor", [](const Config& c) { read_sensor(c); }},
          {"align, compare", "align", [](const Config& c) { read_align_config(c); }},
          {"study", "study", [](const Config& c) { read_study_config(c); }},
          {"simulate, montecarlo: scenarios", "scenario", [](const Config& c) { read_scenario(c); }},
          {"simulate: campaigns", "campaign", [](const Config& c) { read_campaign(c); }}};
}

/// Maps that one reader reads wherever they stand: on the page their keys stand once.
struct Same {
  std::string title, path, as;
};

std::vector<Same> same_maps() {
  return {{"align, compare", "imu.", "imu."},
          {"align, compare", "reference.", "imu."},
          {"study", "runs.reference.", "imu."},
          {"study", "runs.mems.", "imu."},
          {"study", "runs.gnss.", "gnss."},
          {"study", "runs.phases.", "phases."},
          {"simulate: campaigns", "runs.motion.", "motion."}};
}

/// Keys whose fallback is no value of its own: a file's name, or the length of a run.
const std::set<std::string> kDerived{"name",           "imu.name",      "reference.name", "runs.reference.name",
                                     "runs.mems.name", "montecarlo.end"};

/// The keys that the readers of a kind ask for. What is below `columns` is in docs/formats.md.
std::vector<KeyUse> keys_of(const Kind& kind) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "tests/law/keys")) {
    if (entry.path().filename().string().starts_with(kind.files)) files.push_back(entry.path());
  }
  std::sort(files.rbegin(), files.rend());  // replay_receivers, which has most, first
  std::vector<KeyUse> all;
  for (const auto& file : files) {
    const Config config = Config::load(file);
    kind.read(config);
    for (const KeyUse& use : config.asked()) {
      if (use.key.find("columns.") != std::string::npos || use.key.starts_with("article_sensors.")) continue;
      const auto same = std::find_if(all.begin(), all.end(), [&](const KeyUse& k) { return k.key == use.key; });
      if (same == all.end()) {
        all.push_back(use);
      } else if (same->takes.size() < use.takes.size()) {
        same->takes = use.takes;
      }
    }
  }
  // Keys of a map stand below it.
  std::vector<KeyUse> ordered;
  const std::function<void(const std::string&)> append = [&](const std::string& path) {
    for (const KeyUse& use : all) {
      const bool here = use.key.starts_with(path) && use.key.find('.', path.size()) == std::string::npos;
      if (!here) continue;
      ordered.push_back(use);
      append(use.key + ".");
    }
  };
  append("");
  EXPECT_EQ(ordered.size(), all.size());
  return ordered;
}

/// Without those that stand on the page already, `before` this kind.
std::vector<KeyUse> rows_of(const Kind& kind, const std::set<std::string>& before) {
  std::vector<KeyUse> rows;
  for (KeyUse& use : keys_of(kind)) {
    bool stands = false;
    for (const Same& same : same_maps()) {
      if (kind.title != same.title || !use.key.starts_with(same.path)) continue;
      stands = stands || before.contains(same.as + use.key.substr(same.path.size()));
    }
    if (kDerived.contains(use.key) && !use.fallback.empty()) use.fallback.clear(), use.optional = true;
    if (!stands) rows.push_back(use);
  }
  return rows;
}

std::string row_of(const KeyUse& use, const std::string& meaning) {
  const std::string fallback = !use.fallback.empty() ? "`" + use.fallback + "`" : use.optional ? "–" : "required";
  return fmt::format("| `{}` | {} | {} | {} |\n", use.key, use.takes, fallback, meaning);
}

/// The last column of a page, by the title above the table and the key.
std::map<std::string, std::string> meanings(const std::string& page) {
  std::map<std::string, std::string> found;
  std::istringstream in(page);
  std::string title;
  const std::regex row("\\| `([^`]+)` \\|.*\\| (.*) \\|");
  for (std::string line; std::getline(in, line);) {
    std::smatch match;
    if (line.starts_with("## ")) title = line.substr(3);
    if (std::regex_match(line, match, row)) found[title + ":" + match[1].str()] = match[2];
  }
  return found;
}

std::string page_of(const std::string& old) {
  const std::map<std::string, std::string> known = meanings(old);
  const std::size_t head = old.find("\n## ");
  std::string page = head == std::string::npos ? old + "\n" : old.substr(0, head + 1);
  std::set<std::string> before;
  for (const Kind& kind : kinds()) {
    page += fmt::format("## {}\n\n| key | what stands there | if it is missing | what it is |\n|---|---|---|---|\n",
                        kind.title);
    const std::vector<KeyUse> rows = rows_of(kind, before);
    for (const KeyUse& use : rows) {
      before.insert(use.key);
      const auto meaning = known.find(kind.title + ":" + use.key);
      page += row_of(use, meaning == known.end() ? "" : meaning->second);
    }
    page += "\n";
  }
  page.pop_back();
  return page;
}

std::set<std::string> set_of_lines(const std::string& page) {
  std::istringstream in(page);
  std::set<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

TEST(Keys, StandOnTheirPage) {
  const std::filesystem::path file = kSource / "docs/keys.md";
  const std::string old = read_text(file), page = page_of(old);
  if (std::getenv("PISTE_WRITE_KEYS") != nullptr) {
    std::ofstream(file, std::ios::binary) << page;
  } else {
    const std::set<std::string> before = set_of_lines(old), now = set_of_lines(page);
    for (const std::string& line : before) EXPECT_TRUE(now.contains(line)) << "not what the readers ask for: " << line;
    for (const std::string& line : now) EXPECT_TRUE(before.contains(line)) << "missing in docs/keys.md: " << line;
    EXPECT_TRUE(old == page) << "docs/keys.md is not as scripts/keys writes it";
  }
  for (const auto& [key, meaning] : meanings(page)) EXPECT_FALSE(meaning.empty()) << key << " has no description";
}

/// A key that a reader names in the code must be asked for by one of the configurations here.
TEST(Keys, OfTheReadersAreAllAskedFor) {
  std::set<std::string> asked;
  for (const Kind& kind : kinds()) {
    for (const KeyUse& use : keys_of(kind)) asked.insert(use.key.substr(use.key.rfind('.') + 1));
  }
  const std::regex call(
      "(?:\\.|->)(?:has|is_scalar|map|find_map|maps|quantity|magnitude|vector|number|integer|flag|text|words|pairs?|"
      "choice<[A-Za-z]+>|axes|path|existing_file)\\(\\s*\"([a-z_]+)\"|read_within\\([a-z*]+, \"([a-z_]+)\"");
  std::size_t named = 0;
  for (const char* name :
       {"configuration/replay_config", "configuration/replay_keys", "configuration/behaviour_keys",
        "configuration/vehicle_keys", "configuration/imu_source", "configuration/sensor_file", "align/align_config",
        "study/study_config", "sim/scenario", "sim/replay_setup", "sim/campaign"}) {
    const std::string code = read_text(kSource / "src" / (std::string(name) + ".cpp"));
    for (std::sregex_iterator match(code.begin(), code.end(), call), end; match != end; ++match) {
      const std::string key = (*match)[1].matched ? (*match)[1].str() : (*match)[2].str();
      ++named;
      EXPECT_TRUE(asked.contains(key)) << name << ".cpp reads `" << key
                                       << "`, which no file of tests/law/keys asks for";
    }
  }
  EXPECT_GT(named, 150U);
}

}  // namespace
}  // namespace piste::test
