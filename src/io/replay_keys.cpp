#include "io/replay_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <utility>

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

// Reads the key `sigma`, which only logs of `format` may have.
void read_stated_sigma(const Config& source, const Dimension& dimension, std::string_view example, LogFormat format,
                       LogFile& log) {
  if (!source.has("sigma")) return;
  if (log.format != format) source.fail("sigma", "logs in this format have sigmas of their own; leave the key out");
  log.sigma = source.vector("sigma", dimension);
  if (!(log.sigma->minCoeff() > 0)) {
    source.fail("sigma", fmt::format("must be above zero on each axis, such as `{}`", example));
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

LogFile read_gnss_file(const Config& source, DataFile data) {
  LogFile log = read_log_file(
      source, {LogFormat::kCsv, LogFormat::kKfGins, LogFormat::kRtklibPos, LogFormat::kNmea, LogFormat::kUbx}, data);
  read_stated_sigma(source, dimension::kLength, "2 2 4 m", LogFormat::kNmea, log);
  if (source.has("sigma_velocity")) {
    if (log.format != LogFormat::kNmea) {
      source.fail("sigma_velocity", "logs in this format have sigmas of their own; leave the key out");
    }
    log.sigma_velocity = source.quantity("sigma_velocity", dimension::kVelocity);
    if (!(*log.sigma_velocity > 0)) source.fail("sigma_velocity", "must be above zero, such as `0.1 m/s`");
  }
  return log;
}

LogFile read_attitude_file(const Config& source) {
  LogFile log = read_log_file(source, {LogFormat::kCsv, LogFormat::kInspva});
  read_stated_sigma(source, dimension::kAngle, "0.05 0.05 0.1 deg", LogFormat::kInspva, log);
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
  if (const auto drift = source.find_map("drift")) {
    GaussMarkov process{drift->vector("sigma", dimension::kLength),
                        drift->quantity("correlation_time", dimension::kTime)};
    if (!(process.sigma.minCoeff() > 0))
      drift->fail("sigma", "must be above zero on each axis, such as `0.4 0.4 0.7 m`");
    if (!(process.correlation_time > 0)) drift->fail("correlation_time", "must be above zero, such as `60 s`");
    options.drift = process;
  }
  return options;
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
