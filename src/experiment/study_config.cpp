#include "piste/experiment/study_config.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "piste/core/error.h"
#include "piste/io/replay_keys.h"

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
  config.finish();
  if (study.runs.empty()) {
    throw ConfigError(config.file().string(),
                      "names no `runs:`; a campaign is a list of runs, each with `name`, `reference`, "
                      "`gnss` and `mems`");
  }
  return study;
}

}  // namespace piste
