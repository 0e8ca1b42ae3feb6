#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "gps_time.h"
#include "io/fix_quality.h"
#include "log_formats.h"
#include "log_week.h"
#include "math/time.h"
#include "piste/math/units.h"

namespace piste::log_formats {
namespace {

using std::chrono::days;
using std::chrono::sys_days;

constexpr double kKnot = 1852 / kHour;  // m/s
constexpr std::string_view kNoGeoid =
    "the geoid separation is empty, and others are not, so that the height above the ellipsoid is not known; let the "
    "receiver write it, or use a log in another format";

/// How the sentences of a file are written.
struct Dialect {
  bool checked = true;  ///< sentences have a checksum: one without a right one is refused
  bool geoid = true;    ///< the height of the geoid is stated: a GGA without it is refused
};

struct Place {
  Geodetic position;
  FixQuality quality = FixQuality::kUnknown;
  std::uint8_t satellites = 0;
  bool above_sea = false;  ///< the height is, as the geoid's is not stated
  bool repeats = false;    ///< of GNS, which may repeat the place of a GGA of the same time
};

/// The contents of one sentence.
struct Contents {
  std::optional<double> time_of_day;
  bool opens_epoch = false;  ///< its time of day is that of the fix
  std::optional<sys_days> date;
  std::optional<Place> place;
  std::optional<Vector3d> sigma;
  Correlation correlation = Correlation::Zero();
  std::optional<Vector3d> velocity;  ///< north, east; down is not stated
  bool untimed = false;              ///< the velocity has no time of its own
  bool without_fix = false;
  bool estimated = false;  ///< the receiver says that it dead-reckons
  bool unchecked = false;  ///< read without a right checksum
};

/// One sentence that is read, its fields counted from the one after its name.
class Sentence {
 public:
  Sentence(const TextReader& reader, const Dialect& dialect) : reader_(reader), dialect_(dialect) {}
  const Dialect& dialect() const { return dialect_; }

  void require_fields(std::size_t least) const {
    if (reader_.fields().size() <= least) {
      reader_.fail(fmt::format("{} fields in {}, {} at least are expected", reader_.fields().size() - 1,
                               reader_.fields()[0], least),
                   RowFault::Kind::kFields);
    }
  }
  std::size_t fields() const { return reader_.fields().size(); }
  std::string_view text(std::size_t i) const { return reader_.fields()[i]; }
  double number(std::size_t i) const { return reader_.number(i); }
  std::optional<double> find(std::size_t i) const {
    return text(i).empty() ? std::nullopt : std::optional(reader_.number(i));
  }

  // hhmmss.ss
  std::optional<double> time_of_day(std::size_t i) const {
    if (text(i).empty()) return std::nullopt;
    const double packed = number(i);
    const double hour = std::floor(packed / 1e4), minute = std::floor(packed / 100) - 100 * hour,
                 second = packed - 1e4 * hour - 100 * minute;
    if (!(packed >= 0 && hour < 24 && minute < 60 && second < 61)) {
      reader_.fail(fmt::format("`{}` is no time of day; hhmmss.ss is expected", text(i)));
    }
    return kHour * hour + 60 * minute + second;
  }

  // ddmm.mmmm and the letter after it [deg]
  double angle(std::size_t i, char positive, char negative) const {
    const double packed = number(i);
    const double degrees = std::floor(packed / 100), minutes = packed - 100 * degrees;
    const bool letter = text(i + 1).size() == 1 && (text(i + 1)[0] == positive || text(i + 1)[0] == negative);
    if (!(packed >= 0 && minutes < 60) || !letter) {
      reader_.fail(fmt::format("`{},{}` is no angle; degrees and minutes such as 4630.1234,{} are expected", text(i),
                               text(i + 1), positive));
    }
    return (text(i + 1)[0] == negative ? -1 : 1) * (degrees + minutes / 60);
  }

  double metres(std::size_t i) const {
    if (text(i + 1) != "M") fail(fmt::format("unit `{}` of a height; M is expected", text(i + 1)));
    return number(i);
  }

  [[noreturn]] void fail(const std::string& what) const { reader_.fail(what); }

 private:
  const TextReader& reader_;
  const Dialect& dialect_;
};

std::optional<sys_days> date_of(const Sentence& s, double year, double month, double day) {
  const auto date = day_of(year, month, day);
  if (!date) s.fail(fmt::format("{:g}-{:g}-{:g} is no date", year, month, day));
  return date;
}

FixQuality quality_of(const Sentence& s) {
  constexpr std::size_t kIndicator = 6;
  const auto number = number_in(s.text(kIndicator), TextReader::Separator::kComma);
  if (const auto quality = quality_of_nmea(number.value_or(0))) return *quality;
  s.fail(fmt::format("quality `{}` of GGA; 0 to 6 are fixes that a receiver measured", s.text(kIndicator)));
}

// The best of GNS's modes, one letter a constellation. Nothing if none has a fix.
std::optional<FixQuality> quality_of_modes(std::string_view modes) {
  using enum FixQuality;
  constexpr std::array<std::pair<char, FixQuality>, 6> kBestFirst{
      {{'R', kFixed}, {'P', kPrecise}, {'F', kFloat}, {'D', kDifferential}, {'A', kSingle}, {'E', kDeadReckoned}}};
  for (const auto& [letter, quality] : kBestFirst) {
    if (modes.find(letter) != std::string_view::npos) return quality;
  }
  return std::nullopt;
}

// Of a sentence that may be the first of its epoch.
Contents opening(const Sentence& s, std::size_t fields) {
  s.require_fields(fields);
  Contents contents;
  contents.time_of_day = s.time_of_day(1);
  contents.opens_epoch = true;
  return contents;
}

Contents read_gga(const Sentence& s) {
  Contents contents = opening(s, 14);
  if (s.text(6) == "0") {
    contents.without_fix = true;
    return contents;
  }
  if (!contents.time_of_day) s.fail("a fix without its time of day");
  Place place;
  place.quality = quality_of(s);
  place.satellites = satellites_of(number_in(s.text(7), TextReader::Separator::kComma).value_or(0));
  place.above_sea = s.text(11).empty();
  if (place.above_sea && s.dialect().geoid) {
    s.fail(std::string(kNoGeoid));
  }
  const double geoid = place.above_sea ? 0 : s.metres(11);
  place.position = geodetic_degrees(s.angle(2, 'N', 'S'), s.angle(4, 'E', 'W'), s.metres(9) + geoid);
  contents.place = place;
  return contents;
}

// The place of several constellations together, which receivers write instead of GGA or in addition to it.
Contents read_gns(const Sentence& s) {
  Contents contents = opening(s, 11);
  const auto quality = quality_of_modes(s.text(6));
  if (!quality) {
    contents.without_fix = true;
    return contents;
  }
  if (!contents.time_of_day) s.fail("a fix without its time of day");
  Place place;
  place.quality = *quality;
  place.repeats = true;
  place.above_sea = s.text(10).empty();
  if (place.above_sea && s.dialect().geoid) s.fail(std::string(kNoGeoid));
  const double geoid = place.above_sea ? 0 : s.number(10);
  place.position = geodetic_degrees(s.angle(2, 'N', 'S'), s.angle(4, 'E', 'W'), s.number(9) + geoid);
  contents.place = place;
  return contents;
}

Contents read_gst(const Sentence& s) {
  Contents contents = opening(s, 8);
  const auto north = s.find(6), east = s.find(7), down = s.find(8);
  if (north && east && down) contents.sigma = Vector3d(*north, *east, *down);
  // Of the ellipse of errors: its semi-axes, and the azimuth of the larger.
  const auto larger = s.find(3), smaller = s.find(4), azimuth = s.find(5);
  if (contents.sigma && larger && smaller && azimuth) {
    const double angle = kDegree * *azimuth;
    Matrix3d covariance = contents.sigma->cwiseAbs2().asDiagonal();
    covariance(0, 1) = covariance(1, 0) = (*larger * *larger - *smaller * *smaller) * std::sin(angle) * std::cos(angle);
    contents.correlation = correlations(covariance);
  }
  return contents;
}

Vector3d velocity_along(double knots, double course) {
  const double direction = kDegree * course;
  return kKnot * knots * Vector3d(std::cos(direction), std::sin(direction), 0);
}

Contents read_rmc(const Sentence& s) {
  Contents contents = opening(s, 11);
  if (s.text(2) != "A") return contents;  // the clock may be free
  constexpr std::size_t kMode = 12;
  contents.estimated = s.fields() > kMode && s.text(kMode) == "E";
  const auto knots = s.find(7), course = s.find(8);
  if (knots && (course || *knots == 0))  // a receiver that stands need not know a course
    contents.velocity = velocity_along(*knots, course.value_or(0));
  if (const auto packed = s.find(9)) {
    const double day = std::floor(*packed / 1e4), month = std::floor(*packed / 100) - 100 * day,
                 year = *packed - 1e4 * day - 100 * month;
    contents.date = date_of(s, year + (year < 80 ? 2000 : 1900), month, day);
  }
  return contents;
}

// Of the epoch that is open, as VTG has no time.
Contents read_vtg(const Sentence& s) {
  s.require_fields(8);
  const auto course = s.find(1), knots = s.find(5);
  Contents contents;
  if (knots && (course || *knots == 0)) contents.velocity = velocity_along(*knots, course.value_or(0));
  contents.untimed = true;
  return contents;
}

// Stamped when sent: its time need not be that of the fix.
Contents read_zda(const Sentence& s) {
  s.require_fields(4);
  Contents contents;
  contents.time_of_day = s.time_of_day(1);
  const auto day = s.find(2), month = s.find(3), year = s.find(4);
  if (contents.time_of_day && day && month && year) contents.date = date_of(s, *year, *month, *day);
  return contents;
}

// The sentence of a line: behind the stamp of a terminal or the frame of a binary protocol, within the quotes and
// before the empty cells of a spreadsheet. Nothing if there is none.
std::string_view sentence_in(std::string_view line) {
  const auto begins = [&](std::size_t at) {
    constexpr std::size_t kName = 5;
    const std::string_view name = line.substr(at + 1, kName);
    return line.substr(at).size() > kName + 1 && line[at + 1 + kName] == ',' &&
           std::all_of(name.begin(), name.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  };
  std::size_t start = 0;
  if (!line.starts_with('$') && !line.starts_with('!')) {
    do {
      start = line.find('$', start);
      if (start == std::string_view::npos) return {};
    } while (!begins(start) && ++start > 0);
  }
  const auto up_to = [&](std::string_view marks) {
    const std::size_t end = line.find_last_not_of(marks);
    return end == std::string_view::npos || end < start ? std::string_view() : line.substr(start, end + 1 - start);
  };
  // Behind the checksum there may be a stamp.
  constexpr std::size_t kChecksum = 3;
  constexpr std::string_view kHex = "0123456789ABCDEFabcdef", kBehind = ",; \t\"";
  const std::size_t star = line.find('*', start), end = star + kChecksum;
  const bool cut = star != std::string_view::npos && end < line.size() &&
                   kBehind.find(line[end]) != std::string_view::npos &&
                   line.substr(star + 1, 2).find_first_not_of(kHex) == std::string_view::npos;
  if (cut) return line.substr(start, end - start);
  const std::string_view checked = up_to(", \t\"");  // without one, empty fields are the sentence's own
  const bool ends = checked.size() > kChecksum && checked[checked.size() - kChecksum] == '*';
  return ends ? checked : up_to(" \t\"");
}

// The text between `$` and `*`, where there is no checksum that could be right.
std::string_view unchecked_body(std::string_view sentence) {
  return sentence.substr(1, std::min(sentence.find('*'), sentence.size()) - 1);
}

/// Reads the current line of `reader`. The result is empty for a sentence that is skipped.
Contents read_sentence(TextReader& reader, const Dialect& dialect) {
  const std::string_view sentence = sentence_in(reader.line());
  if (sentence.empty()) {
    constexpr std::size_t kSmallestFrame = 8;  // bytes, of u-blox
    const std::size_t frame = reader.line().find("\xB5\x62");
    if (frame != std::string_view::npos && reader.line().size() >= frame + kSmallestFrame) return {};
    reader.fail("no NMEA sentence: `$…*HH` is expected; is the line cut, or the log a binary one (format: ubx)?",
                RowFault::Kind::kText);
  }
  auto body = nmea_body(sentence);
  const bool unchecked = !body;
  if (unchecked && dialect.checked) {
    reader.fail("the checksum `*HH` is missing or wrong; is the line cut or garbled? Delete it",
                RowFault::Kind::kChecksum);
  }
  if (unchecked) body = unchecked_body(sentence);
  const std::string_view name = body->substr(0, body->find(','));
  if (name.size() != 5 || name.starts_with('P') || sentence.starts_with('!')) return {};
  constexpr std::array<std::pair<std::string_view, Contents (*)(const Sentence&)>, 6> kSentences{{{"GGA", read_gga},
                                                                                                  {"GNS", read_gns},
                                                                                                  {"GST", read_gst},
                                                                                                  {"RMC", read_rmc},
                                                                                                  {"VTG", read_vtg},
                                                                                                  {"ZDA", read_zda}}};
  for (const auto& [kind, read] : kSentences) {
    if (name.substr(2) != kind) continue;
    reader.split(*body);
    Contents contents = read(Sentence(reader, dialect));
    contents.unchecked = unchecked;
    return contents;
  }
  return {};
}

// How the sentences of a file are written: without checksums if of many not one has a right one, as some loggers leave
// them out, and a spreadsheet rewrites the numbers; without the geoid if no GGA states it.
Dialect dialect_of(const LogFile& log) {
  constexpr std::size_t kMany = 10, kGeoidOfGga = 11, kGeoidOfGns = 10;
  Dialect dialect{false, false};
  std::size_t sentences = 0;
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  while (!(dialect.checked && dialect.geoid) && reader.next()) {
    const std::string_view sentence = sentence_in(reader.line());
    if (sentence.empty()) continue;
    ++sentences;
    dialect.checked = dialect.checked || nmea_body(sentence);
    const std::string_view body = unchecked_body(sentence);
    const std::string_view kind = body.size() < 5 ? std::string_view() : body.substr(2, 3);
    if (dialect.geoid || (kind != "GGA" && kind != "GNS")) continue;
    const std::size_t geoid = kind == "GGA" ? kGeoidOfGga : kGeoidOfGns;
    reader.split(body);
    dialect.geoid = reader.fields().size() > geoid && !reader.fields()[geoid].empty();
  }
  dialect.checked = dialect.checked || sentences < kMany;
  return dialect;
}

/// The day of each time of day, in order. A new day begins where the time falls back by more than half a day, or where
/// a sentence states a date.
class Calendar {
 public:
  explicit Calendar(sys_days first) : day_(first) {}
  sys_days pass(double time_of_day, const std::optional<sys_days>& stated) {
    if (stated) {
      day_ = *stated;
    } else if (time_of_day < last_ - kDay / 2) {
      day_ += days(1);
    }
    last_ = time_of_day;
    return day_;
  }

 private:
  sys_days day_;
  double last_ = 0;
};

/// The day of the first time of day: the first stated date less the number of midnights before it. Nothing if no date
/// is stated.
std::optional<sys_days> first_day(const LogFile& log, const Dialect& dialect) {
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  Calendar from_zero{sys_days{}};
  while (reader.next()) {
    try {
      const Contents contents = read_sentence(reader, dialect);
      if (!contents.time_of_day) continue;
      const auto passed = from_zero.pass(*contents.time_of_day, std::nullopt).time_since_epoch();
      if (contents.date) return *contents.date - passed;
    } catch (const RowError&) {  // it is reported when its row is read
    }
  }
  return std::nullopt;
}

/// The contents of all sentences with the same time of day.
struct Epoch : Contents {
  sys_days day;
  std::size_t line = 0;  ///< of the place
};

class EpochReader {
 public:
  EpochReader(const LogFile& log, const Dialect& dialect, sys_days first)
      : reader_(log.file, TextReader::Separator::kComma, log.content), dialect_(dialect), calendar_(first) {}

  /// Goes to the next epoch that has a place; false at the end of the file.
  bool next() {
    while (reader_.next()) {
      const Contents contents = read_sentence(reader_, dialect_);
      unchecked_ += contents.unchecked ? 1 : 0;
      without_fix_ += contents.without_fix ? 1 : 0;
      const bool changes = contents.opens_epoch && contents.time_of_day && contents.time_of_day != open_.time_of_day;
      if (changes) close();
      add(contents);
      if (changes && done_.place) return true;
    }
    close();
    return done_.place.has_value();
  }

  const Epoch& epoch() const { return done_; }
  RowSource row() const { return {reader_.file(), RowSource::Counts::kLines, done_.line}; }
  std::size_t without_fix() const { return without_fix_; }
  std::size_t unchecked() const { return unchecked_; }

 private:
  void close() {
    done_ = std::exchange(open_, {});
    if (done_.time_of_day) done_.day = calendar_.pass(*done_.time_of_day, done_.date);
  }
  void add(const Contents& contents) {
    if (contents.opens_epoch && contents.time_of_day) open_.time_of_day = contents.time_of_day;
    if (contents.place && open_.place && (contents.place->repeats || open_.place->repeats)) {
      if (!contents.place->repeats) open_.place = contents.place;
      return;
    }
    if (contents.place && open_.place) {
      reader_.fail("a second GGA of the same time; keep those of one receiver, and of one talker",
                   RowFault::Kind::kTimeRepeated);
    }
    if (contents.place) {
      open_.place = contents.place;
      open_.line = reader_.line_number();
    }
    if (contents.sigma) {
      open_.sigma = contents.sigma;
      open_.correlation = contents.correlation;
    }
    if (contents.velocity && !(contents.untimed && (open_.velocity || !open_.time_of_day)))
      open_.velocity = contents.velocity;
    open_.estimated = open_.estimated || contents.estimated;
    if (contents.date && contents.time_of_day == open_.time_of_day) open_.date = contents.date;
  }

  TextReader reader_;
  Dialect dialect_;
  Calendar calendar_;
  Epoch open_, done_;
  std::size_t without_fix_ = 0, unchecked_ = 0;
};

}  // namespace

std::optional<std::string_view> nmea_body(std::string_view line) {
  if (line.size() < 4 || line[line.size() - 3] != '*') return std::nullopt;
  unsigned stated = 0;
  const char* const end = line.data() + line.size();
  const auto [stop, error] = std::from_chars(end - 2, end, stated, 16);
  if (error != std::errc{} || stop != end) return std::nullopt;
  const std::string_view body = line.substr(1, line.size() - 4);
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  if (sum != stated) return std::nullopt;
  return body;
}

GnssRecording read_gnss_nmea(const LogFile& log, RowFaults* faults) {
  const Dialect dialect = dialect_of(log);
  const auto first = first_day(log, dialect);
  EpochReader epochs(log, dialect, first.value_or(sys_days{}));
  GnssRecording gnss{log.file, {}};
  WeekTime times(log.order());
  bool has_velocity = false;
  const auto epoch = [&] {
    const Epoch& e = epochs.epoch();
    const RowSource row = epochs.row();
    if (!first) {
      throw DataError(row.where(),
                      "the time of day has no date: no RMC with status A follows or precedes it, and no ZDA; let the "
                      "receiver write RMC as well");
    }
    GeodeticFix fix;
    fix.time = times.next(gps_time(e.day, *e.time_of_day, TimeSystem::kUtc), row);
    fix.position = e.place->position;
    fix.quality = e.estimated ? FixQuality::kDeadReckoned : e.place->quality;
    fix.satellites = e.place->satellites;
    gnss.above_sea += e.place->above_sea ? 1 : 0;
    if (!e.sigma && !log.sigma && is_for_use(faults)) {
      row.fail(
          "no GST of this time with the sigmas of latitude, longitude and altitude; let the receiver write GST as "
          "often "
          "as GGA, or state them in the configuration for all fixes: `sigma: 2 2 4 m` (north, east, down)");
    }
    fix.sigma_position = e.sigma.value_or(unknown_sigma());
    fix.correlation = e.correlation;
    if (e.velocity && log.sigma_velocity) {
      fix.velocity = {*e.velocity, unknown_sigma()};  // the stated sigmas follow
      has_velocity = true;
    }
    check_fix(fix, log, row);
    gnss.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return epochs.next(); }, epoch);
  gnss.without_fix = epochs.without_fix();
  gnss.unchecked = epochs.unchecked();
  if (is_for_use(faults) && log.sigma_velocity && !has_velocity && !gnss.fixes.empty()) {
    throw DataError(
        log.file,
        "no RMC with status A gives a fix its speed and course, nor does a VTG; let the receiver write RMC as often as "
        "GGA, or take `sigma_velocity` out of the configuration");
  }
  return gnss;
}

std::optional<GpsTime> first_time_nmea(const LogFile& log) {
  const Dialect dialect = dialect_of(log);
  const auto first = first_day(log, dialect);
  if (!first) return std::nullopt;
  EpochReader epochs(log, dialect, *first);
  for (;;) {
    try {
      if (!epochs.next()) return std::nullopt;
      return gps_time(epochs.epoch().day, *epochs.epoch().time_of_day, TimeSystem::kUtc);
    } catch (const RowError&) {  // a row without a time, which its reader reports
    }
  }
}

// HDT and THS have no time: it is that of the sentence before them that has one.
FixRecording<HeadingFix> read_heading_nmea(const LogFile& log, double sigma) {
  const Dialect dialect = dialect_of(log);
  const auto first = first_day(log, dialect);
  if (!first) throw DataError(log.file + ":1", "no RMC or ZDA states the date; let the receiver write RMC as well");
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  FixRecording<HeadingFix> recording{log.file, {}};
  Calendar calendar(*first);
  WeekTime times(log.order());
  std::optional<double> time_of_day;
  bool taken = true;  // the heading of this time
  sys_days day = *first;
  while (reader.next()) {
    const Contents contents = read_sentence(reader, dialect);
    if (contents.opens_epoch && contents.time_of_day && contents.time_of_day != time_of_day) {
      time_of_day = contents.time_of_day;
      day = calendar.pass(*time_of_day, std::nullopt);
      taken = false;
    }
    const std::string_view sentence = sentence_in(reader.line());
    const auto body = dialect.checked ? nmea_body(sentence) : std::optional(unchecked_body(sentence));
    const std::string_view name = body ? body->substr(0, body->find(',')) : "";
    if (taken || name.size() != 5 || (name.substr(2) != "HDT" && name.substr(2) != "THS")) continue;
    reader.split(*body);
    const Sentence s(reader, dialect);
    s.require_fields(2);
    if (s.text(1).empty() || s.text(2) == "V") continue;
    HeadingFix fix;
    fix.time = times.next(gps_time(day, *time_of_day, TimeSystem::kUtc), reader);
    fix.heading = kDegree * s.number(1);
    fix.sigma = sigma;
    recording.fixes.push_back(fix);
    taken = true;
  }
  return recording;
}

}  // namespace piste::log_formats
