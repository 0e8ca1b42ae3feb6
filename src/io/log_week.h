#pragma once
/// The GPS week of a log.

#include <optional>

#include "math/gps_time.h"
#include "piste/io/log_io.h"

namespace piste {

/// The GPS time of the first row that states one. Nothing for a log without weeks or dates, such as a csv.
std::optional<GpsTime> first_gps_time(const LogFile& log);

namespace log_formats {

std::optional<GpsTime> first_time_columns(const LogFile& log);
std::optional<GpsTime> first_time_nmea(const LogFile& log);
std::optional<GpsTime> first_time_novatel(const LogFile& log);
std::optional<GpsTime> first_time_rtklib(const LogFile& log);
std::optional<GpsTime> first_time_ubx(const LogFile& log);

/// The instants of TIM-TM2: rising edges of the external interrupt, with a valid time. Throws RowError.
std::vector<GpsTime> ubx_marks(const LogFile& log);

}  // namespace log_formats
}  // namespace piste
