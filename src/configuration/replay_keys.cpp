#include "configuration/replay_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "configuration/column_keys.h"
#include "core/receiver_class.h"

namespace piste {
namespace {

Block block_named(const Config& config, const std::string& name) {
  std::vector<std::string> names;
  for (const BlockInfo& row : kBlocks) {
    if (row.name == name) return row.block;
    names.emplace_back(row.name);
  }
  const auto near = nearest_spelling(name, names);
  config.fail("estimate", fmt::format("there is no state block `{}`{}; there are: {}", name,
                                      near ? fmt::format(", perhaps `{}`", *near) : "", fmt::join(names, ", ")));
}

// Throws if the run has no source that observes the block.
void check_sources(const Config& config, Block block, const FilterOptions& filter) {
  const BlockInfo& row = info(block);
  const bool there = row.observed ? row.observed(filter) : !row.implied || row.process(filter);
  if (!there) {
    config.fail("estimate", fmt::format("{} needs {}; add it, or leave the block out", row.name, row.needs));
  }
}

// Reads the key `sigma`, which replaces the sigmas of the log.
void read_stated_sigma(const Config& source, const Dimension& dimension, std::string_view example, LogFile& log) {
  if (!source.has("sigma")) return;
  log.sigma = source.vector("sigma", dimension);
  if (!(log.sigma->minCoeff() > 0)) {
    source.fail("sigma", fmt::format("must be above zero on each axis, such as `{}`", example));
  }
}

// Reads the key `sigma_velocity`: one value, or those of north, east and down.
void read_sigma_velocity(const Config& source, LogFile& log) {
  if (!source.has("sigma_velocity")) return;
  std::istringstream words(source.text("sigma_velocity"));
  double first = 0, second = 0;
  if (words >> first >> second) {
    log.sigma_velocity = source.vector("sigma_velocity", dimension::kVelocity);
  } else {
    log.sigma_velocity = Vector3d::Constant(source.quantity("sigma_velocity", dimension::kVelocity));
  }
  if (!(log.sigma_velocity->minCoeff() > 0)) source.fail("sigma_velocity", "must be above zero, such as `0.1 m/s`");
}

// Reads a factor of sigmas, a plain number.
double read_scale(const Config& source, std::string_view key) {
  const double scale = source.number(key, 1);
  if (!(scale > 0)) source.fail(key, "must be above zero, such as 1.5");
  return scale;
}

// Reads the factor of all positions, or one for each quality.
void read_position_scale(const Config& source, SigmaScales& scales) {
  if (!source.is_map("sigma_scale")) {
    scales.position = read_scale(source, "sigma_scale");
    return;
  }
  const Config map = source.map("sigma_scale");
  for (std::size_t i = 0; i < kQualities; ++i) {
    scales.of_quality[i] = read_scale(map, kQualityNames[i]);
  }
}

void read_used_qualities(const Config& source, LogFile& log) {
  for (const std::string& name : source.words("use_quality")) {
    const auto place = std::find(kQualityNames.begin(), kQualityNames.end(), name);
    if (place == kQualityNames.end()) {
      const std::vector<std::string> names(kQualityNames.begin(), kQualityNames.end());
      const auto near = nearest_spelling(name, names);
      source.fail("use_quality", fmt::format("there is no quality `{}`{}; there are: {}", name,
                                             near ? fmt::format(", perhaps `{}`", *near) : "", fmt::join(names, ", ")));
    }
    log.use_quality.push_back(static_cast<FixQuality>(place - kQualityNames.begin()));
  }
}

// Reads a share of the stated sigmas: one value, or those of north, east and down.
Vector3d read_share(const Config& drift) {
  std::istringstream text(drift.text("share"));
  const std::vector<std::string> words{std::istream_iterator<std::string>(text), {}};
  Vector3d share;
  if (words.size() == 1) {
    share.setConstant(drift.number("share"));
  } else if (words.size() == 3) {
    try {
      for (std::size_t i = 0; i < 3; ++i) {
        share(static_cast<Eigen::Index>(i)) = parse_quantity(words[i], dimension::kRatio);
      }
    } catch (const std::invalid_argument& e) {
      drift.fail("share", e.what());
    }
  } else {
    drift.fail("share", "one number is expected, such as 0.7, or those of north, east and down");
  }
  if (!(share.minCoeff() > 0 && share.maxCoeff() < 1)) {
    drift.fail("share", "the slow part over the whole sigma is expected, above 0 and below 1, such as 0.7");
  }
  return share;
}

PositionDrift read_position_drift(const Config& drift) {
  const bool of_stated = drift.has("share");
  if (of_stated && drift.has("sigma")) drift.fail("sigma", "give either it or `share`, a part of the stated sigmas");
  const Vector3d size = of_stated ? read_share(drift) : drift.vector("sigma", dimension::kLength);
  const double time = drift.quantity("correlation_time", dimension::kTime);
  if (!(size.minCoeff() > 0)) drift.fail("sigma", "must be above zero on each axis, such as `0.4 0.4 0.7 m`");
  if (!(time > 0)) drift.fail("correlation_time", "must be above zero, such as `60 s`");
  if (!of_stated && drift.has("most_white")) drift.fail("most_white", "is of a `share`; give `sigma` or it");
  PositionDrift process = of_stated ? PositionDrift::of_share(size, time) : PositionDrift({size, time});
  process.most_white = drift.quantity("most_white", dimension::kLength, process.most_white);
  if (!(process.most_white > 0)) drift.fail("most_white", "must be above zero, such as `0.02 m`");
  return process;
}

// As antennas on helmets and packs move: all axes alike.
GaussMarkov read_lever_arm_sway(const Config& sway) {
  GaussMarkov process{Vector3d::Constant(sway.quantity("sigma", dimension::kLength)),
                      sway.quantity("correlation_time", dimension::kTime)};
  if (!(process.sigma.x() > 0)) sway.fail("sigma", "must be above zero, such as `0.03 m`");
  if (!(process.correlation_time > 0)) sway.fail("correlation_time", "must be above zero, such as `0.5 s`");
  return process;
}

// Throws if a receiver's columns name no sigmas, and none are stated.
void require_sigmas(const Config& source, const LogFile& log) {
  const ColumnMap& map = *log.columns;
  if (!log.sigma && map.find("sigma") == nullptr && map.find("covariance") == nullptr &&
      map.find("horizontal_accuracy") == nullptr) {
    source.fail({},
                "no sigmas: state `sigma: 3 3 6 m` (north, east, down), or name `sigma`, or `horizontal_accuracy` and "
                "`vertical_accuracy`, under `columns`");
  }
  const bool moves = map.find("velocity") != nullptr || map.find("speed") != nullptr;
  if (moves && !log.sigma_velocity && map.find("sigma_velocity") == nullptr && map.find("speed_accuracy") == nullptr) {
    source.fail({},
                "velocities without sigmas: state `sigma_velocity: 0.1 m/s`, or name `sigma_velocity` or "
                "`speed_accuracy` under `columns`");
  }
}

}  // namespace

std::vector<Block> read_estimate(const Config& config, const FilterOptions& filter, std::vector<Block> fallback) {
  std::vector<Block> named;
  if (!config.has("estimate")) named = std::move(fallback);
  for (const std::string& name : config.words("estimate")) {
    const Block block = block_named(config, name);
    if (std::find(named.begin(), named.end(), block) != named.end()) {
      config.fail("estimate", fmt::format("`{}` stands twice", name));
    }
    check_sources(config, block, filter);
    named.push_back(block);
  }
  named = with_implied_blocks(filter, std::move(named));
  std::erase_if(named, [&](Block block) { return is_navigation(block) || !has_error(filter, block); });
  return named;
}

std::optional<AdaptationOptions> read_adaptation(const Config& config) {
  AdaptationOptions options;
  if (!config.has("adapt")) return std::nullopt;
  if (config.is_scalar("adapt")) return config.flag("adapt") ? std::optional(options) : std::nullopt;
  const Config map = config.map("adapt");
  options.within = map.number("within", options.within);
  if (!(options.within > 1 && options.within <= 1000)) {
    map.fail("within", "a factor of sigmas is expected, above 1 and up to 1000, such as 10");
  }
  options.time = map.quantity("time", dimension::kTime, options.time);
  options.imu_time = map.quantity("imu_time", dimension::kTime, options.imu_time);
  if (!(options.time > 0)) map.fail("time", "must be above zero, such as `3600 s`");
  if (!(options.imu_time > 0)) map.fail("imu_time", "must be above zero, such as `36000 s`");
  return options;
}

LogFile read_gnss_file(const Config& source, DataFile data) {
  LogFile log = read_log_file(source,
                              {LogFormat::kCsv, LogFormat::kKfGins, LogFormat::kRtklibPos, LogFormat::kNmea,
                               LogFormat::kUbx, LogFormat::kNovatel, LogFormat::kColumns},
                              data);
  log.shared_stamps = source.choice<bool>("stamps", {{"as_logged", false}, {"shared", true}}, false);
  read_stated_sigma(source, dimension::kLength, "2 2 4 m", log);
  read_sigma_velocity(source, log);
  log.sigma_scales = {.height = read_scale(source, "sigma_height_scale"),
                      .velocity = read_scale(source, "sigma_velocity_scale")};
  read_position_scale(source, log.sigma_scales);
  read_used_qualities(source, log);
  if (log.format == LogFormat::kColumns) {
    log.columns = read_column_map(source, gnss_quantities());
    require_sigmas(source, log);
  }
  return log;
}

LogFile read_attitude_file(const Config& source) {
  LogFile log = read_log_file(source, {LogFormat::kCsv, LogFormat::kInspva, LogFormat::kColumns});
  read_stated_sigma(source, dimension::kAngle, "0.05 0.05 0.1 deg", log);
  if (log.format == LogFormat::kColumns) {
    log.columns = read_column_map(source, attitude_quantities());
    if (!log.sigma && log.columns->find("sigma") == nullptr && log.columns->find("covariance") == nullptr) {
      source.fail(
          {}, "no sigmas: state `sigma: 0.05 0.05 0.1 deg` (roll, pitch, heading), or name `sigma` under `columns`");
    }
  }
  return log;
}

GnssOptions read_gnss_options(const Config& source, const LogFile& log) {
  GnssOptions options;
  options.name = std::filesystem::path(log.file).stem().string();
  options.lever_arm = source.vector("lever_arm", dimension::kLength, Vector3d::Zero());
  if (source.has("use")) {
    const std::vector<std::string> use = source.words("use");
    const auto has = [&](std::string_view word) { return std::find(use.begin(), use.end(), word) != use.end(); };
    options.use_position = has("position");
    options.use_velocity = has("velocity");
    const auto known = static_cast<std::size_t>(options.use_position) + static_cast<std::size_t>(options.use_velocity);
    if (known == 0 || known != use.size())
      source.fail("use", "right would be `position`, `velocity` or `position velocity`");
  }
  options.delay = source.quantity("delay", dimension::kTime, options.delay);
  if (source.has("velocity_delay")) {
    options.velocity_delay = source.quantity("velocity_delay", dimension::kTime);
    if (!options.use_velocity) {
      source.fail("velocity_delay",
                  "the velocities of this receiver are not used; add `velocity` to `use`, or leave the key out");
    }
  }
  options.velocity_averaging = source.quantity("velocity_averaging", dimension::kTime, 0);
  if (options.velocity_averaging < 0 || options.velocity_averaging > kAveragingTimes.back())
    source.fail("velocity_averaging", fmt::format("must lie between 0 and {:g} s", kAveragingTimes.back()));
  if (source.has("drift") && !source.is_map("drift")) {
    options.white = source.choice<bool>("drift", {{"none", true}});
  } else if (const auto drift = source.find_map("drift")) {
    options.drift = read_position_drift(*drift);
  }
  if (const auto sway = source.find_map("lever_arm_sway")) options.lever_arm_sway = read_lever_arm_sway(*sway);
  return options;
}

std::string size_text(const PositionDrift& drift) {
  const Vector3d& s = drift.sigma;
  if (!drift.of_stated) return fmt::format("{:.5g} {:.5g} {:.5g} m", s.x(), s.y(), s.z());
  const std::string one = fmt::format("{:.5g}", s.x()), down = fmt::format("{:.5g}", s.z());
  return one == down && one == fmt::format("{:.5g}", s.y()) ? one : fmt::format("{} {:.5g} {}", one, s.y(), down);
}

std::vector<Interval> read_outages(const Config& config) {
  std::vector<Interval> outages;
  for (const auto& [start, length] : config.pairs("outages", dimension::kTime)) {
    if (!(length > 0))
      config.fail("outages", fmt::format("[{}, {}]: a length above zero is expected: [start, length]", start, length));
    outages.push_back({start, start + length});
  }
  return outages;
}

Interval read_span(const Config& config) {
  Interval span;
  const auto map = config.find_map("span");
  if (!map) return span;
  span = {map->quantity("start", dimension::kTime, 0), map->quantity("end", dimension::kTime, 0)};
  if (span.end != 0 && !(span.end > span.start)) map->fail("end", "must lie after start, or be `0 s` for all");
  return span;
}

}  // namespace piste
