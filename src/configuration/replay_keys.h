#pragma once
/// Reads the keys that say how a recording is replayed. They stand in the configuration of `replay`, in that of `study`
/// and in scenarios.

#include <vector>

#include "piste/configuration/imu_source.h"
#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/core/state_table.h"
#include "piste/io/config.h"

namespace piste {

/// The blocks that the key `estimate` names, or `fallback` if it is missing, and the drift of every source of `filter`
/// that has one. A block for which the sensor of `filter` has no error is left out: a bias or scale whose sigma is 0, a
/// drift without a process. Throws ConfigError if a block is unknown, stands twice, or has no source that observes it.
std::vector<Block> read_estimate(const Config& config, const FilterOptions& filter, std::vector<Block> fallback = {});

/// Reads the key `adapt`: true, false, or a map with `within`, `time` and `imu_time`. Throws ConfigError.
std::optional<AdaptationOptions> read_adaptation(const Config& config);

/// Reads the log of a receiver: the keys file, format, ignore_columns, repair and columns; `sigma` (north, east, down)
/// and `sigma_velocity` (one value, or three) replace the sigmas of the log. Throws ConfigError.
LogFile read_gnss_file(const Config& source, DataFile data = DataFile::kMustExist);

/// Reads the log of a reference attitude: the keys file, format, ignore_columns, repair and columns; `sigma` (roll,
/// pitch, heading) replaces the sigmas of the log. Throws ConfigError.
LogFile read_attitude_file(const Config& source);

/// Reads the keys lever_arm, use, delay, velocity_delay and drift of a receiver. Its name is that of its log. Throws
/// ConfigError.
GnssOptions read_gnss_options(const Config& source, const LogFile& log);

/// The size of a slow error as the key `drift` has it: shares, or metres with their unit.
std::string size_text(const PositionDrift& drift);

/// Reads the list `outages` of pairs [start, length]. Empty if the key is missing. Throws ConfigError.
std::vector<Interval> read_outages(const Config& config);

/// Reads the key `span: {start, end}`. {0, 0} is the whole log. Throws ConfigError.
Interval read_span(const Config& config);

}  // namespace piste
