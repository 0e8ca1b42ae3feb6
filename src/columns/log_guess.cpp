#include "piste/columns/log_guess.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "column_guess.h"
#include "io/lower_case.h"
#include "io/novatel_ascii.h"
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

// Whether a text begins with a sentence of NMEA without its `$`: a talker of two letters, and its name.
bool names_sentence(std::string_view name) {
  constexpr std::array<std::string_view, 10> kSentences{"GGA", "RMC", "GST", "VTG", "ZDA",
                                                        "GSA", "GSV", "GLL", "GNS", "TXT"};
  return name.size() > 4 && std::isupper(static_cast<unsigned char>(name[0])) != 0 &&
         std::find(kSentences.begin(), kSentences.end(), name.substr(2, 3)) != kSentences.end();
}

// Whether nearly all lines hold a sentence behind a comma: behind a stamp, and no field of a log of several sensors.
bool has_stamped_sentences(std::string_view head) {
  constexpr double kNearly = 0.9;
  double lines = 0, sentences = 0;
  TextReader reader("", TextReader::Separator::kComma, head.substr(0, head.rfind('\n')));
  while (reader.next()) {
    ++lines;
    const std::size_t at = reader.line().find(",$");
    sentences += at != std::string_view::npos && names_sentence(reader.line().substr(at + 2)) ? 1 : 0;
  }
  return lines > 0 && sentences > kNearly * lines;
}

// `$GPGGA,` and the like.
bool holds_nmea(std::string_view head) {
  for (std::size_t at = head.find('$'); at != std::string_view::npos; at = head.find('$', at + 1)) {
    const std::string_view name = head.substr(at + 1, 6);
    const bool within = at > 0 && head[at - 1] == ',';  // a field of a log of several sensors
    if (!within && name.size() == 6 && name[5] == ',' && names_sentence(name)) return true;
  }
  return has_stamped_sentences(head);
}

// How often a frame or a sentence stands in a text.
std::size_t count_of(std::string_view text, std::string_view part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

// Whether a comment of Xsens states the rate. Without it the rate follows from the samples' own time.
bool states_rate(std::string_view head) {
  const std::string lower = lower_case(head.substr(0, head.find("Acc_X")));
  return lower.starts_with("//") && (has(lower, "sample rate") || has(lower, "update rate"));
}

constexpr std::string_view kPvt{"\xB5\x62\x01\x07"}, kPosLlh{"\xB5\x62\x01\x02"};

// Whether sentences of NMEA stand between frames of u-blox, of which none is a position, or few compared with the
// sentences. Receivers answer a configuration with such frames, and programs ask for single ones.
bool is_nmea_with_frames(std::string_view content) {
  return holds_nmea(content) && 2 * count_of(content, kPvt) < count_of(content, "GGA,") + count_of(content, "GNS,") + 1;
}

// Whether a line is a row of a solution of RTKLIB, of date and time, or week and seconds, and 13 numbers.
bool is_rtklib(std::string_view head) {
  constexpr std::size_t kFields = 15, kWithVelocities = 24, kQuality = 5, kMostQuality = 7, kMostSatellites = 99;
  TextReader reader("", TextReader::Separator::kSpaces, head.substr(0, head.find('\n')));
  if (!reader.next() || (reader.fields().size() != kFields && reader.fields().size() != kWithVelocities)) return false;
  const auto& fields = reader.fields();
  const auto value = [&](std::size_t i) { return number_in(fields[i], TextReader::Separator::kSpaces).value_or(-1); };
  const auto whole = [&](std::size_t i, double most) {
    return value(i) == std::floor(value(i)) && value(i) >= 1 && value(i) <= most;
  };
  const bool calendar = fields[0].size() == 10 && fields[0][4] == '/' && fields[0][7] == '/' && has(fields[1], ":");
  const bool week =
      whole(0, 1e4) && value(1) >= 0 && value(1) <= kWeek && fields[0].find('.') == std::string_view::npos;
  return (calendar || week) && whole(kQuality, kMostQuality) && whole(kQuality + 1, kMostSatellites) &&
         std::abs(number_in(fields[2], TextReader::Separator::kSpaces).value_or(1e3)) <= 90;
}

LogGuess found_by(LogKind kind, LogFormat format, std::string why) {
  LogGuess guess;
  guess.kind = kind;
  guess.format = format;
  guess.why = std::move(why);
  return guess;
}

// Frames of u-blox whose positions are in messages that are not read, or of which too few are.
LogGuess guess_ubx(const std::string& file, std::string_view content) {
  constexpr std::size_t kFew = 10;
  const std::size_t pvt = count_of(content, kPvt), others = count_of(content, kPosLlh);
  if (pvt < kFew && others > pvt) {
    throw DataError(file + ":1", fmt::format("has {} NAV-PVT of u-blox, and its places stand in {} NAV-POSLLH, which "
                                             "piste does not read, as they have neither date nor kind of fix; let the "
                                             "receiver write NAV-PVT, or convert the log to NMEA with GGA and RMC",
                                             pvt == 0 ? "no" : fmt::format("only {}", pvt), others));
  }
  if (pvt == 0 && !has(content, "\xB5\x62\x0D\x03") && !has(content, "\xB5\x62\x01\x3C")) {
    throw DataError(file + ":1",
                    "has frames of u-blox and no NAV-PVT among them, so that no place is in it; let the receiver write "
                    "NAV-PVT (raw measurements are for RTKLIB, whose solution piste reads)");
  }
  return found_by(LogKind::kGnss, LogFormat::kUbx, "frames that begin with B5 62");
}

// NMEA needs a place with a height.
LogGuess guess_nmea(const std::string& file, std::string_view content, std::string why) {
  if (!has(content, "GGA,") && !has(content, "GNS,")) {
    throw DataError(file + ":1",
                    "has sentences of NMEA, and neither GGA nor GNS among them: RMC and GLL have no height; let the "
                    "receiver write GGA as well");
  }
  return found_by(LogKind::kGnss, LogFormat::kNmea, std::move(why));
}

void put_aside(LogGuess& guess, std::string why) {
  guess.part = LogGuess::Part::kNone;
  guess.aside = std::move(why);
}

// Whether a line is an ASCII log of NovAtel, cut or not.
bool holds_novatel(std::string_view head) {
  TextReader reader("", TextReader::Separator::kComma, head);
  constexpr std::string_view kNames[] = {"POSA,", "VELA,", "IMUA,", "IMUSA,", "IMUXA,", "IMUSXA,", "INSPVA"};
  while (reader.next()) {
    const std::string_view line = reader.line();
    if (!line.starts_with('#') && !line.starts_with('%')) continue;
    const std::string_view header = line.substr(0, line.find(';'));
    if (header.size() < line.size() &&
        std::any_of(std::begin(kNames), std::end(kNames), [&](std::string_view name) { return has(header, name); }))
      return true;
  }
  return false;
}

// IMU, receiver and attitudes of NovAtel, by the names of their logs.
std::optional<LogGuess> guess_novatel(std::string_view content) {
  std::vector<LogGuess> found;
  const bool imu = has(content, "RAWIMUXA,") || has(content, "RAWIMUSXA,");
  if (imu) found.push_back(found_by(LogKind::kImu, LogFormat::kNovatel, "logs named RAWIMUXA or RAWIMUSXA"));
  if (const std::string_view solution = log_formats::novatel_solution(content); !solution.empty())
    found.push_back(found_by(LogKind::kGnss, LogFormat::kNovatel, fmt::format("logs named {}POSA", solution)));
  if (has(content, "INSPVA")) {
    found.push_back(found_by(LogKind::kAttitude, LogFormat::kInspva, "logs named INSPVA"));
    if (imu) put_aside(found.back(), "attitudes of the receiver's own filter, by the same IMU");
  }
  if (!imu && (has(content, "RAWIMUA,") || has(content, "RAWIMUSA,"))) {
    found.push_back(found_by(LogKind::kImu, LogFormat::kNovatel, "logs named RAWIMUA or RAWIMUSA"));
    put_aside(found.back(), std::string(log_formats::kUntypedImu));
  }
  if (found.empty()) return std::nullopt;
  LogGuess first = std::move(found.front());
  first.beside.assign(std::make_move_iterator(found.begin() + 1), std::make_move_iterator(found.end()));
  return first;
}

// Only what that reader needs makes it one of its files; of others the columns are guessed.
std::optional<LogGuess> guess_csv(std::string_view header) {
  TextReader reader("", TextReader::Separator::kComma, header);
  if (!reader.next()) return std::nullopt;
  const auto& cells = reader.fields();
  const auto has_all = [&](const std::vector<std::string>& names) {
    return std::all_of(names.begin(), names.end(),
                       [&](const auto& name) { return std::find(cells.begin(), cells.end(), name) != cells.end(); });
  };
  const auto has_triad = [&](std::string_view name, std::initializer_list<std::string_view> units) {
    return std::any_of(units.begin(), units.end(), [&](std::string_view unit) {
      return has_all(
          {fmt::format("{}_x_{}", name, unit), fmt::format("{}_y_{}", name, unit), fmt::format("{}_z_{}", name, unit)});
    });
  };
  if (!has_all({"time_s"})) return std::nullopt;
  const auto csv = [](LogKind kind, std::string why) { return found_by(kind, LogFormat::kCsv, std::move(why)); };
  if (has_triad("gyro", {"rad_s", "deg_s"}) && has_triad("accel", {"m_s2", "g"}))
    return csv(LogKind::kImu, "columns gyro_x and accel_x with their units");
  if (has_triad("dtheta", {"rad", "deg"}) && has_triad("dvel", {"m_s"}))
    return csv(LogKind::kImu, "columns dtheta_x and dvel_x with their units");
  if (has_all({"latitude_deg", "longitude_deg", "height_m"})) return csv(LogKind::kGnss, "column latitude_deg");
  if (has_all({"roll_deg", "pitch_deg", "heading_deg"})) return csv(LogKind::kAttitude, "column heading_deg");
  return std::nullopt;
}

/// What rows of `time latitude longitude height` never are, as those of a calendar or a clock: places in whole degrees.
class UnlikePlaces {
 public:
  void take(const TextReader& reader) {
    for (std::size_t i = 1; i < 3; ++i) whole_ = whole_ && is_whole(reader.number(i));
    ++rows_;
  }
  bool is_sure() const { return rows_ > 2 && whole_; }

 private:
  static bool is_whole(double value) { return value == std::floor(value); }
  bool whole_ = true;
  std::size_t rows_ = 0;
};

// Rows of plain numbers. IMU and receiver may both have seven columns; the size of the numbers separates them.
std::optional<LogGuess> guess_numbers(const std::string& file, std::string_view head, std::string_view content) {
  const std::string_view line = head.substr(0, head.find('\n'));
  if (has(line, ";") && has(line, ",")) return std::nullopt;  // decimal commas
  TextReader reader(file, TextReader::Separator::kSpaces, head);
  bool is_place = true;  // by latitude, longitude, and sigmas of positions and velocities
  std::size_t columns = 0, rows = 0, backwards = 0;
  double largest = 0, smallest_sigma = 1e300, first = 0, last = 0, velocity = 0;
  UnlikePlaces unlike;
  try {
    while (rows < kRows && reader.next()) {
      const std::size_t found = reader.fields().size();
      if (columns == 0) columns = found;
      if (found != columns) break;  // the last line read may be cut
      if (columns < 7) return std::nullopt;
      const double time = reader.number(0);
      if (rows == 0) first = time;
      if (rows > 0 && time < last && last - time < kWeek / 2) ++backwards;
      last = time;
      velocity += std::hypot(reader.number(4), reader.number(5), reader.number(6));
      for (std::size_t i = 1; i < 4; ++i) largest = std::max(largest, std::abs(reader.number(i)));
      is_place = is_place && std::abs(reader.number(1)) <= 90 && std::abs(reader.number(2)) <= 360;
      for (std::size_t i = 10; i < 13 && columns > 12; ++i) is_place = is_place && reader.number(i) >= 0;
      for (std::size_t i = 4; i < 7; ++i) smallest_sigma = std::min(smallest_sigma, reader.number(i));
      unlike.take(reader);
      ++rows;
    }
  } catch (const RowError&) {
    if (rows < 2) return std::nullopt;
  }
  constexpr double kMostSeconds = 1e8;  // a larger time is since 1970, and not of these formats
  if (std::abs(first) > kMostSeconds) return std::nullopt;
  constexpr std::size_t kFewBackwards = 4;  // one row in so many; with more, the first number is no time
  if (rows == 0 || kFewBackwards * backwards > rows) return std::nullopt;
  is_place = is_place && smallest_sigma >= 0 && !unlike.is_sure();
  if ((columns == 13 || columns == 14) && is_place)
    return found_by(LogKind::kGnss, LogFormat::kKfGins, fmt::format("{} numbers a row", columns));
  if (columns != 7) return std::nullopt;
  if (is_place && largest > 10)
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

// Whether a line is a row of KITTI's oxts: 30 numbers from latitude and longitude to five modes.
bool is_kitti(std::string_view line) {
  constexpr std::size_t kColumns = 30, kModes = 5;
  TextReader reader("", TextReader::Separator::kSpaces, line);
  if (!reader.next() || reader.fields().size() != kColumns) return false;
  for (std::size_t i = 0; i < kColumns; ++i) {
    const auto value = number_in(reader.fields()[i], TextReader::Separator::kSpaces);
    const double most = i == 0 ? 90 : i == 1 ? 180 : 1e9;
    if (!value || std::abs(*value) > most || (i + kModes >= kColumns && *value != std::floor(*value))) return false;
  }
  return true;
}

// Texts that are no table of columns, with what would be right.
constexpr std::string_view kNoArrow =
    "rows of Arduino's serial monitor, whose time stamps end with ` -> `; replace ` -> ` by a comma, and put a header "
    "with names such as time,acc_x,acc_y,acc_z,temperature,gyro_x,gyro_y,gyro_z above";
constexpr std::string_view kNoJson =
    "JSON, which piste does not read; write it as a CSV with one row a sample and a header with names and units";
constexpr std::string_view kNoGpx =
    "GPX or another XML, whose tracks have neither sigmas nor velocities; log the receiver's own output (nmea, ubx, "
    "rtklib_pos), or write a CSV with time, latitude, longitude and height";
constexpr std::string_view kNoVectorNav =
    "sentences of VectorNav: VNIMU has no time, and VNINS is of the sensor's own filter; export its binary output as a "
    "CSV with TimeStartup or GpsTow";
constexpr std::string_view kNoKitti =
    "rows of KITTI's oxts without their times, which stand in timestamps.txt; and their places are of a filter that "
    "has used this IMU, so that a replay of both counts it twice: give the logs of a receiver and of an IMU themselves";

constexpr std::string_view kNoSheet =
    "sentences of NMEA that a spreadsheet or a program has rewritten: the `$` or the commas between the fields are "
    "lost, and with them digits; give the receiver's own log, or import and export the lines as text";

// Whether a line is a sentence of NMEA without its dollar, or with other marks than commas between the fields.
bool is_rewritten_nmea(std::string_view line) {
  const std::size_t first = line.find_first_not_of("\"$ ");
  if (first == std::string_view::npos || !names_sentence(line.substr(first))) return false;
  const std::string_view behind = line.substr(first + 5);
  return behind.starts_with(',') || behind.starts_with(';') || behind.starts_with('\t') || behind.starts_with('"');
}

// Whether a text begins with a list of objects, on one line or several.
bool is_json_array(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n", 1);
  return text.starts_with('[') && first != std::string_view::npos && text[first] == '{';
}

// Why a log of a known kind cannot be used, and what could be; empty if it is of none.
std::string_view why_unusable(std::string_view head) {
  const std::string_view line = head.substr(0, head.find('\n')),
                         text = head.substr(head.find_first_not_of(" \t\r\n\xEF\xBB\xBF"));
  if (head.starts_with("$VN")) return kNoVectorNav;
  if (has(line, " -> ") && std::isdigit(static_cast<unsigned char>(line.front())) != 0) return kNoArrow;
  if (text.starts_with('{') || is_json_array(text)) return kNoJson;
  if (text.starts_with("<?xml") || text.starts_with("<gpx") || text.starts_with("<kml")) return kNoGpx;
  if (is_rewritten_nmea(text.substr(0, text.find('\n')))) return kNoSheet;
  return is_kitti(head.substr(0, head.find('\n'))) ? kNoKitti : std::string_view();
}

}  // namespace

LogGuess guess_log(const std::string& file, std::string_view content) {
  if (content.find_first_not_of(" \t\r\n") == std::string_view::npos)
    throw DataError(file + ":1", "the file is empty; a log is expected");
  const std::string_view head = content.substr(0, kLooked);
  if (head.starts_with("$IMURAW")) return found_by(LogKind::kImu, LogFormat::kImr, "its mark `$IMURAW`");
  if (holds_novatel(head)) {
    if (auto logs = guess_novatel(content)) return *logs;
  }
  if (holds_ubx(head) && is_nmea_with_frames(content))
    return guess_nmea(file, content, "sentences such as $GPGGA, between frames without a position");
  if (holds_ubx(head)) return guess_ubx(file, content);
  if (holds_nmea(head)) return guess_nmea(file, content, "sentences such as $GPGGA");
  if (has(head, "Counter") && has(head, "Acc_X") && states_rate(head))
    return found_by(LogKind::kImu, LogFormat::kXsensAscii, "columns Counter and Acc_X");
  if (head.starts_with("%") && (has(head, "latitude(") || has(head, "ecef(m)") || has(head, "-baseline(m)")))
    return found_by(LogKind::kGnss, LogFormat::kRtklibPos, "a header of RTKLIB");
  if (is_rtklib(head))
    return found_by(LogKind::kGnss, LogFormat::kRtklibPos, "rows as RTKLIB writes them, without its header");
  if (const std::string_view why = why_unusable(head); !why.empty())
    throw DataError(file + ":1", fmt::format("holds {}", why));
  const std::string_view line = head.substr(0, head.find('\n'));
  if (auto csv = guess_csv(line)) return *csv;
  if (auto numbers = guess_numbers(file, head, content)) return *numbers;
  if (auto columns = guess_columns(file, content)) return *columns;
  if (std::any_of(head.begin(), head.end(), [](char c) { return c == '\0'; }))
    throw DataError(file + ":1", "is binary and none of the logs that piste reads: ubx (NAV-PVT) and imr");
  const std::string known = known_columns(content);
  throw DataError(
      file + ":1",
      fmt::format("is none of the logs that piste reads; it begins with `{}`. {}A CSV needs a header with names and "
                  "units, such as time_s,gyro_x_rad_s,…,accel_x_m_s2,… or time_s,latitude_deg,longitude_deg,"
                  "height_m,sigma_north_m,…; of others, names such as gyro_x, acc_x, latitude and time show what the "
                  "columns hold",
                  line.substr(0, line.find('\r')).substr(0, 80), known.empty() ? "" : known + ". "));
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
