#pragma once
/// The ASCII logs of NovAtel: `#NAME,…,week,seconds,…;fields*CRC`, and short ones `%NAME,week,seconds;fields*CRC`.

#include <cstddef>
#include <optional>
#include <string_view>

#include "io/text_reader.h"
#include "math/gps_time.h"

namespace piste::log_formats {

/// The parts of one line.
struct NovatelLog {
  std::string_view name, header, body;
};

/// The present line of a reader; nothing if it is a sentence of NMEA 0183. Throws RowError if it is neither, or if its
/// CRC is wrong.
std::optional<NovatelLog> novatel_log(const TextReader& reader);

/// Splits the fields behind the header. Throws RowError if they are not as many.
void split_fields(TextReader& reader, const NovatelLog& log, std::size_t expected);

/// GPS time by the fields of week and of its seconds. Throws RowError if they are none.
GpsTime time_of(const TextReader& reader, std::size_t field);

/// That of the header.
GpsTime header_time(TextReader& reader, const NovatelLog& log);

/// Why raw counts of an IMU cannot be used.
inline constexpr std::string_view kUntypedImu =
    "RAWIMUA and RAWIMUSA do not say the type of the IMU, on which the scale of their counts depends; log RAWIMUXA or "
    "RAWIMUSXA";

/// The solution whose positions and velocities are read, such as BEST of BESTPOSA and BESTVELA. Of the solutions in a
/// text it is the one of GNSS alone first, and else the receiver's best. Empty if there is none.
std::string_view novatel_solution(std::string_view text);

}  // namespace piste::log_formats
