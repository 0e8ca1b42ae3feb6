#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include "gps_time.h"
#include "log_formats.h"
#include "math/time.h"
#include "piste/math/units.h"

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

/// One log: `#NAME,…,week,seconds,…;fields*CRC`, or `%NAME,week,seconds;fields*CRC`.
struct AsciiLog {
  std::string_view name, header, body;
};

AsciiLog read_log(const TextReader& reader) {
  const std::string_view line = reader.line();
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
  AsciiLog log;
  log.header = text.substr(0, semicolon);
  log.body = text.substr(std::min(semicolon + 1, text.size()));
  log.name = log.header.substr(0, log.header.find(','));
  return log;
}

void require_fields(const TextReader& reader, std::size_t expected, std::string_view what) {
  if (reader.fields().size() == expected) return;
  reader.fail(fmt::format("{} fields in {}; {} are expected", reader.fields().size(), what, expected),
              RowFault::Kind::kFields);
}

GpsTime time_of(const TextReader& reader, std::size_t field) {
  const double week = reader.number(field), seconds = reader.number(field + 1);
  if (!(week >= 0 && week < 10000 && week == std::floor(week) && seconds >= 0 && seconds <= kWeek)) {
    reader.fail(
        fmt::format("`{},{}` is no GPS week and seconds of week", reader.fields()[field], reader.fields()[field + 1]));
  }
  return {static_cast<int>(week), seconds};
}

// GPS time of the header, whose log has none in its body.
GpsTime header_time(TextReader& reader, const AsciiLog& log) {
  reader.split(log.header);
  if (reader.line().starts_with('%')) {
    require_fields(reader, 3, "the short header");
    return time_of(reader, 1);
  }
  require_fields(reader, 10, "the header");
  return time_of(reader, 5);
}

bool is_valid(std::string_view status) {
  return status == "INS_SOLUTION_GOOD" || status == "INS_SOLUTION_FREE" || status == "INS_ALIGNMENT_COMPLETE";
}

}  // namespace

AttitudeRecording read_attitude_inspva(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  AttitudeRecording attitude{log.file, {}};
  WeekTime times(log.order());
  const auto degrees = [&](std::size_t field) -> Vector3d {
    return kDegree * Vector3d(reader.number(field), reader.number(field + 1), reader.number(field + 2));
  };
  const auto row = [&] {
    if (reader.line().starts_with('$') && nmea_body(reader.line())) return;
    const AsciiLog line = read_log(reader);
    const bool extended = line.name == "INSPVAXA" || line.name == "INSPVAXSA";
    if (!extended && line.name != "INSPVAA" && line.name != "INSPVASA") return;
    GpsTime time = extended ? header_time(reader, line) : GpsTime{};
    reader.split(line.body);
    require_fields(reader, extended ? 23 : 12, line.name);
    if (!is_valid(reader.fields()[extended ? 0 : 11])) {
      ++attitude.not_valid;
      return;
    }
    if (!extended) time = time_of(reader, 0);
    if (!extended && !log.sigma && is_for_use(faults)) {
      reader.fail(
          fmt::format("{} has no sigmas; state them in the configuration: `sigma: 0.05 0.05 0.1 deg` (roll, "
                      "pitch, heading), or log INSPVAXA",
                      line.name));
    }
    EulerFix fix;
    fix.angles = degrees(extended ? 9 : 8);
    fix.sigma = extended ? degrees(18) : unknown_sigma();
    check_attitude(fix, log, reader);
    fix.time = times.next(time, reader);
    attitude.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return attitude;
}

}  // namespace piste::log_formats
