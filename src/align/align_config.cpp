#include "piste/align/align_config.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "configuration/replay_keys.h"
#include "piste/core/error.h"

namespace piste {
MountedImu read_mounted_imu(const Config& config, DataFile data) {
  MountedImu imu;
  imu.source = read_imu_source(config, data);
  imu.name = config.text("name", std::filesystem::path(imu.source.log.file).stem().string());
  const bool is_file_name =
      !imu.name.empty() && imu.name != "." && imu.name != ".." && imu.name.find_first_of("/\\") == std::string::npos;
  if (!is_file_name) config.fail("name", "becomes the name of a folder, such as `mt9a_1`");
  imu.conditioning.imu = imu.source.conditioning;
  imu.conditioning.gyro_range = imu.source.sensor.gyro.range;
  imu.conditioning.accel_range = imu.source.sensor.accel.range;
  return imu;
}

std::optional<Phases> read_phases(const Config& config) {
  if (!config.has("phases")) return std::nullopt;
  if (config.is_scalar("phases")) {
    if (config.text("phases") != "auto") {
      config.fail("phases", "right would be `auto`, or a map such as `{before: [0 s, 60 s], run: [70 s, 160 s]}`");
    }
    return std::nullopt;
  }
  const Config map = config.map("phases");
  const auto phase = [&](const char* key) -> std::optional<Interval> {
    if (!map.has(key)) return std::nullopt;
    const auto [start, end] = map.pair(key, dimension::kTime);
    if (!(end > start)) map.fail(key, "must end after it starts");
    return Interval{start, end};
  };
  const Phases phases{phase("before"), phase("run"), phase("after")};
  std::optional<Interval> last;
  for (const auto& [name, p] : {std::pair{"before", phases.before}, {"run", phases.run}, {"after", phases.after}}) {
    if (!p) continue;
    if (last && p->start < last->end) map.fail(name, "must not start before the phase above it has ended");
    last = p;
  }
  if (!last) config.fail("phases", "names none of before, run, after");
  return phases;
}

AlignConfig read_align_config(const std::filesystem::path& file) { return read_align_config(Config::load(file)); }

AlignConfig read_align_config(const Config& config) {
  AlignConfig align;
  align.file = config.file();
  align.echo = config.source();
  const Interval span = read_span(config);
  std::set<std::string> names;
  for (const Config& imu : config.maps("imu")) {
    MountedImu mounted = read_mounted_imu(imu);
    for (const MountedImu& other : align.imus) refuse_repeated(imu, mounted.source.log, other.source.log);
    align.imus.push_back(std::move(mounted));
    // The body IMU keeps its own time: align() estimates the clock.
    align.imus.back().conditioning.imu.clock_offset = align.imus.back().conditioning.imu.clock_drift = 0;
    align.imus.back().conditioning.span = span;
    if (!names.insert(align.imus.back().name).second) {
      imu.fail("name",
               fmt::format("`{}` stands for two of the IMUs; give each its own `name`", align.imus.back().name));
    }
  }
  if (align.imus.empty()) config.fail("imu", "is missing; name the IMU to be aligned: its file, format and sensor");
  const Config reference = config.map("reference");
  align.reference = read_mounted_imu(reference);
  for (const MountedImu& imu : align.imus) refuse_repeated(reference, align.reference.source.log, imu.source.log);
  if (config.has("low_pass")) {
    align.low_pass = config.quantity("low_pass", dimension::kFrequency);
    if (!(align.low_pass > 0)) config.fail("low_pass", "must be above zero, such as `12 Hz`");
  }
  align.phases = read_phases(config);
  config.finish();
  return align;
}

}  // namespace piste
