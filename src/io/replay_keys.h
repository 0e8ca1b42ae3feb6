#pragma once
/// Keys that say how a recording is replayed, wherever they stand: in the configuration of `replay`, in a scenario.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/core/state_table.h"
#include "piste/io/config.h"
#include "piste/io/imu_source.h"

namespace piste {

/// The blocks that `estimate` names, or `fallback` where the key is absent, and the drift of every source of `filter`
/// that has one. A bias or scale whose sigma is 0 in the sensor of `filter`, and a drift without a process, are left
/// out. Throws ConfigError on a block that is unknown, stands twice, or has nothing to be observed by.
std::vector<Block> read_estimate(const Config& config, const FilterOptions& filter, std::vector<Block> fallback = {});

/// The log of a receiver: file, format and ignore_columns, and `sigma` (north, east, down) of an nmea log without GST
/// and `sigma_velocity` (of north and of east) of one whose RMC is to be used. Throws ConfigError.
LogFile read_gnss_file(const Config& source, DataFile data = DataFile::kMustExist);

/// The log of a reference attitude: the same keys, `sigma` (roll, pitch, heading) of an inspva log without INSPVAXA.
LogFile read_attitude_file(const Config& source);

/// The keys lever_arm, use and drift of a receiver, whose log gives the name. Throws ConfigError.
GnssOptions read_gnss_options(const Config& source, const LogFile& log);

/// The list `outages` of [start, length], as intervals; none where the key is absent. Throws ConfigError.
std::vector<Interval> read_outages(const Config& config);

/// The key `span: {start, end}`; {0, 0} is all.
Interval read_span(const Config& config);

}  // namespace piste
