#pragma once
/// Qualities of fixes as receivers and programs write them.

#include <cstdint>
#include <optional>
#include <string_view>

#include "piste/core/log.h"

namespace piste::log_formats {

/// Of the quality indicator of NMEA's GGA; nothing for 0, which is no fix, and for what no receiver measured.
std::optional<FixQuality> quality_of_nmea(double indicator);

/// Of RTKLIB's Q: 1 fix, 2 float, 3 sbas, 4 dgps, 5 single, 6 ppp, 7 dead reckoning; nothing for others.
std::optional<FixQuality> quality_of_rtklib(double q);

/// A number of satellites as a log has it; 0 for what is no such number.
std::uint8_t satellites_of(double number);

/// Of a word such as `FLOAT`, `RTK_FIXED`, `L1_INT`, `DGPS`, `3D` or `dead reckoning`; nothing for others.
std::optional<FixQuality> quality_of_word(std::string_view word);

}  // namespace piste::log_formats
