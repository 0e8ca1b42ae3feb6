// Configurations of replay, align and study, as if they stood beside the shipped ones: what these name is there.

#include <string>

#include "piste/align/align_config.h"
#include "piste/configuration/replay_config.h"
#include "piste/study/study_config.h"
#include "reader.h"

namespace {

using namespace piste;

void read(const Config& config) {
  if (config.has("runs")) {
    fuzz::require(!read_study_config(config).runs.empty());
  } else if (config.has("reference")) {
    fuzz::require(!read_align_config(config).imus.empty());
  } else {
    const ReplayConfig replay = read_replay_config(config);
    fuzz::require(!replay.gnss.empty() && replay.filter.gnss.size() == replay.gnss.size());
    fuzz::require(replay.filter.attitude.size() == replay.attitude.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path beside = std::filesystem::path(PISTE_SOURCE_DIR) / "config/ski_run.yaml";
  try {
    read(Config::parse(std::string(fuzz::text_of(data, size)), beside));
  } catch (const ConfigError&) {
  }
  return 0;
}
