#include "io/novatel_ascii.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "log_formats.h"
#include "math/time.h"

namespace piste::log_formats {
namespace {

constexpr std::array<std::uint32_t, 256> kCrcTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    table[i] = i;
    for (int bit = 0; bit < 8; ++bit) table[i] = (table[i] >> 1) ^ ((table[i] & 1) != 0 ? 0xEDB88320U : 0U);
  }
  return table;
}();

/// CRC-32 as NovAtel has it: from 0, not inverted.
std::uint32_t crc(std::string_view text) {
  std::uint32_t value = 0;
  for (const char c : text) value = kCrcTable[(value ^ static_cast<unsigned char>(c)) & 0xFF] ^ (value >> 8);
  return value;
}

void require_fields(const TextReader& reader, std::size_t expected, std::string_view what) {
  if (reader.fields().size() == expected) return;
  reader.fail(fmt::format("{} fields in {}; {} are expected", reader.fields().size(), what, expected),
              RowFault::Kind::kFields);
}

}  // namespace

std::optional<NovatelLog> novatel_log(const TextReader& reader) {
  const std::string_view line = reader.line();
  if (line.starts_with('$') && nmea_body(line)) return std::nullopt;
  if (!line.starts_with('#') && !line.starts_with('%')) {
    reader.fail("no ASCII log of NovAtel: `#INSPVAA,…*CRC` is expected; is the line cut, or the file a binary one?",
                RowFault::Kind::kText);
  }
  const std::size_t star = line.rfind('*');
  std::uint32_t stated = 0;
  const char* const end = line.data() + line.size();
  const bool whole = star != std::string_view::npos && line.size() - star == 9 &&
                     std::from_chars(line.data() + star + 1, end, stated, 16).ptr == end;
  if (!whole || crc(line.substr(1, star - 1)) != stated) {
    reader.fail("the CRC is missing or wrong; is the line cut or garbled? Delete it", RowFault::Kind::kChecksum);
  }
  const std::string_view text = line.substr(1, star - 1);
  const std::size_t semicolon = std::min(text.find(';'), text.size());
  NovatelLog log;
  log.header = text.substr(0, semicolon);
  log.body = text.substr(std::min(semicolon + 1, text.size()));
  log.name = log.header.substr(0, log.header.find(','));
  return log;
}

void split_fields(TextReader& reader, const NovatelLog& log, std::size_t expected) {
  reader.split(log.body);
  require_fields(reader, expected, log.name);
}

GpsTime time_of(const TextReader& reader, std::size_t field) {
  const double week = reader.number(field), seconds = reader.number(field + 1);
  if (!(week >= 0 && week < 10000 && week == std::floor(week) && seconds >= 0 && seconds <= kWeek)) {
    reader.fail(
        fmt::format("`{},{}` is no GPS week and seconds of week", reader.fields()[field], reader.fields()[field + 1]));
  }
  return {static_cast<int>(week), seconds};
}

GpsTime header_time(TextReader& reader, const NovatelLog& log) {
  reader.split(log.header);
  if (reader.line().starts_with('%')) {
    require_fields(reader, 3, "the short header");
    return time_of(reader, 1);
  }
  require_fields(reader, 10, "the header");
  return time_of(reader, 5);
}

std::string_view novatel_solution(std::string_view text) {
  constexpr std::array<std::string_view, 5> kSolutions{"BESTGNSS", "BEST", "RTK", "PPP", "PSR"};
  for (const std::string_view solution : kSolutions) {
    if (text.find(fmt::format("#{}POSA,", solution)) != std::string_view::npos) return solution;
  }
  return {};
}

}  // namespace piste::log_formats
