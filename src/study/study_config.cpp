#include "piste/study/study_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "configuration/replay_keys.h"
#include "piste/core/error.h"

namespace piste {
namespace {

RunConfig read_run(const Config& config) {
  RunConfig run;
  run.name = config.text("name");
  run.activity = config.text("activity", "");
  run.reference = read_mounted_imu(config.map("reference"), DataFile::kMayBeMissing);
  if (const auto gnss = config.find_map("gnss")) {
    const LogFile log = read_gnss_file(*gnss, DataFile::kMayBeMissing);
    run.gnss = RunConfig::Receiver{log, read_gnss_options(*gnss, log)};
  }
  run.phases = read_phases(config);
  std::set<std::string> names;
  for (const Config& imu : config.maps("mems")) {
    MountedImu mems = read_mounted_imu(imu, DataFile::kMayBeMissing);
    mems.conditioning.imu.clock_offset = mems.conditioning.imu.clock_drift = 0;
    refuse_repeated(imu, mems.source.log, run.reference.source.log);
    for (const MountedImu& other : run.mems) refuse_repeated(imu, mems.source.log, other.source.log);
    if (!names.insert(mems.name).second) {
      imu.fail("name", fmt::format("`{}` stands for two of the IMUs of this run; give each its own `name`", mems.name));
    }
    run.mems.push_back(std::move(mems));
  }
  if (run.mems.empty()) config.fail("mems", "is missing; name the IMUs that are studied: file, format and sensor");
  if (config.has("truth")) run.truth = config.path("truth");
  return run;
}

// Reads the article that the campaign names, and which of its sensors correspond to the campaign's sensors.
std::optional<ArticleBeside> read_compared_article(const Config& config, const std::vector<RunConfig>& runs) {
  if (!config.has("article")) {
    if (config.has("article_sensors")) config.fail("article_sensors", "name the file of the `article` as well");
    return std::nullopt;
  }
  ArticleBeside out{read_article(config.existing_file("article")), {}};
  const auto counterparts = config.find_map("article_sensors");
  if (!counterparts) return out;
  const std::vector<std::string>& known = out.article.sensors;
  for (const RunConfig& run : runs) {
    for (const MountedImu& imu : run.mems) {
      if (!counterparts->has(imu.name)) continue;
      const std::string name = counterparts->text(imu.name);
      const auto found = std::ranges::find(known, name);
      if (found == known.end()) {
        counterparts->fail(imu.name,
                           fmt::format("`{}` is no sensor of the article; it has: {}", name, fmt::join(known, ", ")));
      }
      out.counterparts[imu.name] = static_cast<std::size_t>(found - known.begin());
    }
  }
  return out;
}

}  // namespace

StudyConfig read_study_config(const std::filesystem::path& file) { return read_study_config(Config::load(file)); }

StudyConfig read_study_config(const Config& config) {
  StudyConfig study;
  study.file = config.file();
  study.echo = config.source();
  study.low_pass = config.quantity("low_pass", dimension::kFrequency, study.low_pass);
  if (!(study.low_pass > 0)) config.fail("low_pass", "must be above zero, such as `12 Hz`");
  std::set<std::string> names;
  for (const Config& run : config.maps("runs")) {
    study.runs.push_back(read_run(run));
    if (!names.insert(study.runs.back().name).second) {
      run.fail("name", fmt::format("`{}` stands for two runs; give each its own `name`", study.runs.back().name));
    }
  }
  study.article = read_compared_article(config, study.runs);
  config.finish();
  if (study.runs.empty()) {
    throw ConfigError(config.file().string(),
                      "names no `runs:`; a campaign is a list of runs, each with `name`, `reference`, "
                      "`gnss` and `mems`");
  }
  return study;
}

}  // namespace piste
