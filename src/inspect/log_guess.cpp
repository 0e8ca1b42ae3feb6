#include "piste/inspect/log_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>

#include "column_guess.h"
#include "io/text_reader.h"
#include "math/time.h"
#include "piste/core/error.h"

namespace piste {
namespace {

constexpr std::size_t kLooked = 64 << 10;  // bytes at the beginning of a file that are looked at
constexpr std::size_t kRows = 50;

bool has(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

// Whether there is a frame of u-blox: two sync bytes, class, id, and a length that is within the bytes.
bool holds_ubx(std::string_view head) {
  for (std::size_t at = head.find("\xB5\x62"); at != std::string_view::npos; at = head.find("\xB5\x62", at + 1)) {
    if (at + 6 > head.size()) return false;
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(head[at + i]); };
    const std::size_t length = byte(4) + 256u * byte(5);
    if (byte(2) <= 0x30 && length <= 4096) return true;
  }
  return false;
}

// `$GPGGA,` and the like.
bool holds_nmea(std::string_view head) {
  for (std::size_t at = head.find('$'); at != std::string_view::npos; at = head.find('$', at + 1)) {
    const std::string_view name = head.substr(at + 1, 6);
    if (name.size() == 6 && name[5] == ',' && std::all_of(name.begin(), name.begin() + 5, [](char c) {
          return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        }))
      return true;
  }
  return false;
}

LogGuess found_by(LogKind kind, LogFormat format, std::string why) {
  LogGuess guess;
  guess.kind = kind;
  guess.format = format;
  guess.why = std::move(why);
  return guess;
}

std::optional<LogGuess> guess_csv(std::string_view header) {
  if (!has(header, "time_s")) return std::nullopt;
  struct Sign {
    std::string_view column;
    LogKind kind;
  };
  for (const Sign sign : {Sign{"gyro_x_", LogKind::kImu},
                          {"dtheta_x_", LogKind::kImu},
                          {"accel_x_", LogKind::kImu},
                          {"latitude_", LogKind::kGnss},
                          {"heading_", LogKind::kAttitude},
                          {"roll_", LogKind::kAttitude}}) {
    const auto at = header.find(sign.column);
    if (at == std::string_view::npos) continue;
    const std::string_view name = header.substr(at, header.find_first_of(", \t\r", at) - at);
    return found_by(sign.kind, LogFormat::kCsv, fmt::format("column {}", name));
  }
  return std::nullopt;
}

// Rows of plain numbers. IMU and receiver may both have seven columns; the size of the numbers shows which it is.
std::optional<LogGuess> guess_numbers(const std::string& file, std::string_view head, std::string_view content) {
  TextReader reader(file, TextReader::Separator::kSpaces, head);
  std::size_t columns = 0, rows = 0, backwards = 0;
  double largest = 0, smallest_sigma = 1e300, first = 0, last = 0, velocity = 0;
  try {
    while (rows < kRows && reader.next()) {
      const std::size_t found = reader.fields().size();
      if (columns == 0) columns = found;
      if (found != columns) break;  // the last line of what was looked at may be cut
      if (columns < 7) return std::nullopt;
      const double time = reader.number(0);
      if (rows == 0) first = time;
      if (rows > 0 && time < last && last - time < kWeek / 2) ++backwards;
      last = time;
      velocity += std::hypot(reader.number(4), reader.number(5), reader.number(6));
      for (std::size_t i = 1; i < 4; ++i) largest = std::max(largest, std::abs(reader.number(i)));
      for (std::size_t i = 4; i < 7; ++i) smallest_sigma = std::min(smallest_sigma, reader.number(i));
      ++rows;
    }
  } catch (const RowError&) {
    if (rows < 2) return std::nullopt;
  }
  constexpr std::size_t kFewBackwards = 4;  // one row in so many; with more, the first number is no time
  if (rows == 0 || kFewBackwards * backwards > rows) return std::nullopt;
  if (columns == 13 || columns == 14)
    return found_by(LogKind::kGnss, LogFormat::kKfGins, fmt::format("{} numbers a row", columns));
  if (columns != 7) return std::nullopt;
  if (smallest_sigma >= 0 && largest > 10)
    return found_by(LogKind::kGnss, LogFormat::kKfGins, "7 numbers a row, the last three not negative");
  LogGuess imu = found_by(LogKind::kImu, LogFormat::kKfGins, "7 numbers a row, as small as increments");
  // As increments they add up to gravity; of others the values may show what they are.
  constexpr double kLeast = 3, kMost = 30;  // m/s²
  const double force = velocity / std::max(last - first, 1e-9);
  if (rows > 2 && !(force > kLeast && force < kMost)) {
    if (auto guess = guess_columns(file, content)) return guess;
  }
  return imu;
}

}  // namespace

LogGuess guess_log(const std::string& file, std::string_view content) {
  if (content.find_first_not_of(" \t\r\n") == std::string_view::npos)
    throw DataError(file + ":1", "the file is empty; a log is expected");
  const std::string_view head = content.substr(0, kLooked);
  if (head.starts_with("$IMURAW")) return found_by(LogKind::kImu, LogFormat::kImr, "its mark `$IMURAW`");
  if (has(head, "INSPVA")) return found_by(LogKind::kAttitude, LogFormat::kInspva, "logs named INSPVA");
  if (holds_ubx(head)) return found_by(LogKind::kGnss, LogFormat::kUbx, "frames that begin with B5 62");
  if (holds_nmea(head))
    return found_by(LogKind::kGnss, LogFormat::kNmea, "sentences that begin with $ and five letters");
  if (has(head, "Counter") && has(head, "Acc_X"))
    return found_by(LogKind::kImu, LogFormat::kXsensAscii, "columns Counter and Acc_X");
  if (head.starts_with("%") && (has(head, "latitude(") || has(head, "ecef(m)") || has(head, "-baseline(m)")))
    return found_by(LogKind::kGnss, LogFormat::kRtklibPos, "a header of RTKLIB");
  const std::string_view line = head.substr(0, head.find('\n'));
  if (auto csv = guess_csv(line)) return *csv;
  if (auto numbers = guess_numbers(file, head, content)) return *numbers;
  if (auto columns = guess_columns(file, content)) return *columns;
  const bool text = std::none_of(head.begin(), head.end(), [](char c) { return c == '\0'; });
  throw DataError(
      file + ":1",
      text ? fmt::format(
                 "is none of the logs that piste reads; it begins with `{}`. A CSV needs a header with names and "
                 "units, such as time_s,gyro_x_rad_s,…,accel_x_m_s2,… or time_s,latitude_deg,longitude_deg,"
                 "height_m,sigma_north_m,…; of others, names such as gyro_x, acc_x, latitude and time show what the "
                 "columns hold",
                 line.substr(0, 80))
           : std::string("is binary and none of the logs that piste reads: ubx (NAV-PVT) and imr"));
}

std::string_view name_of(LogKind kind) {
  switch (kind) {
    case LogKind::kImu:
      return "IMU";
    case LogKind::kGnss:
      return "GNSS";
    case LogKind::kAttitude:
      return "attitude";
  }
  return "";
}

}  // namespace piste
