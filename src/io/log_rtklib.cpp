#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "gps_time.h"
#include "io/fix_quality.h"
#include "log_formats.h"
#include "log_week.h"
#include "math/numbers.h"
#include "math/time.h"

namespace piste::log_formats {
namespace {

constexpr std::array<std::pair<std::string_view, TimeSystem>, 3> kTimeSystems{
    {{"GPST", TimeSystem::kGps}, {"UTC", TimeSystem::kUtc}, {"JST", TimeSystem::kJapan}}};

/// The columns, from the header.
struct PosHeader {
  TimeSystem system = TimeSystem::kGps;
  bool sexagesimal = false;
  std::vector<std::string> names;  ///< from the quality flag on

  std::optional<std::size_t> find(std::string_view name) const {
    const auto place = std::find(names.begin(), names.end(), name);
    if (place == names.end()) return std::nullopt;
    return first_named() + static_cast<std::size_t>(place - names.begin());
  }
  std::size_t first_named() const { return 2 + (sexagesimal ? 6 : 2) + 1; }
  std::size_t fields() const { return first_named() + names.size(); }
};

// `a/b/c` or `a:b:c`
std::optional<std::array<double, 3>> split_three(std::string_view text, char separator) {
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [end, error] = read_number(text.data(), text.data() + text.size(), values[i]);
    if (error != std::errc{} || !(values[i] >= 0 && values[i] < 1e4)) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (i == 2) break;
    if (!text.starts_with(separator)) return std::nullopt;
    text.remove_prefix(1);
  }
  if (!text.empty()) return std::nullopt;
  return values;
}

[[noreturn]] void no_time(const TextReader& reader) {
  reader.fail(fmt::format("`{} {}` is no time; right would be such as 2025/07/08 19:34:18.499, or week and seconds",
                          reader.fields()[0], reader.fields()[1]));
}

GpsTime calendar_time(const TextReader& reader, TimeSystem system) {
  const auto date = split_three(reader.fields()[0], '/');
  const auto clock = split_three(reader.fields()[1], ':');
  if (!date || !clock) no_time(reader);
  const auto day = day_of((*date)[0], (*date)[1], (*date)[2]);
  const auto [hour, minute, second] = *clock;
  if (!day || !(hour < 24 && minute < 60 && second < 61)) no_time(reader);
  return gps_time(*day, hour * kHour + minute * 60 + second, system);
}

GpsTime time_of(const TextReader& reader, TimeSystem system) {
  if (reader.fields()[0].find('/') != std::string_view::npos) return calendar_time(reader, system);
  const double week = reader.number(0), seconds = reader.number(1);
  if (!(week >= 0 && week < 10000 && week == std::floor(week) && seconds >= 0 && seconds <= kWeek)) {
    no_time(reader);
  }
  return gps_time({static_cast<int>(week), seconds}, system);
}

FixQuality quality_of(const TextReader& reader, double q) {
  if (const auto quality = quality_of_rtklib(q)) return *quality;
  reader.fail(fmt::format("quality Q = {:g}; 1 (fixed) to 7 are RTKLIB's", q));
}

double angle_of(const TextReader& reader, std::size_t& field, bool sexagesimal) {
  if (!sexagesimal) return reader.number(field++);
  const double sign = reader.fields()[field].starts_with('-') ? -1 : 1;  // −0° 30′ is negative too
  const double degrees = std::abs(reader.number(field)), minutes = reader.number(field + 1),
               seconds = reader.number(field + 2);
  if (!(minutes >= 0 && minutes < 60 && seconds >= 0 && seconds <= 60)) {
    reader.fail("minutes and seconds of an angle must lie between 0 and 60");
  }
  field += 3;
  return sign * (degrees + minutes / 60 + seconds / 3600);
}

// Always ends the reading: without a header no row can be read.
[[noreturn]] void refuse(const TextReader& reader, const std::string& what) { throw DataError(reader.where(), what); }

// The header line that names the columns, or nothing if the line is another comment.
std::optional<PosHeader> header_of(const TextReader& reader) {
  const std::string_view line = reader.line();
  if (line.find("ecef(m)") != std::string_view::npos || line.find("-baseline(m)") != std::string_view::npos) {
    refuse(reader, "latitude, longitude and height are expected; set out-solformat=llh in RTKLIB");
  }
  if (line.find("height=") != std::string_view::npos && line.find("/geodetic") != std::string_view::npos) {
    refuse(reader, "heights above the geoid; set out-height=ellipsoidal in RTKLIB");
  }
  if (line.find("=Tokyo/") != std::string_view::npos) {
    refuse(reader, "coordinates on the Tokyo datum; set out-datum=wgs84 in RTKLIB");
  }
  if (line.find("latitude(") == std::string_view::npos) return std::nullopt;
  PosHeader header;
  std::vector<std::string> words;
  for (std::string_view word : reader.fields()) {
    while (word.starts_with('%')) word.remove_prefix(1);
    if (!word.empty()) words.emplace_back(word);
  }
  const std::string name = words.size() < 4 ? std::string() : words[0];
  const auto* const system =
      std::find_if(kTimeSystems.begin(), kTimeSystems.end(), [&](const auto& known) { return known.first == name; });
  if (system == kTimeSystems.end()) {
    refuse(reader, fmt::format("time system `{}`; set out-timesys to gpst, utc or jst in RTKLIB", name));
  }
  header.system = system->second;
  header.sexagesimal = words[1].find('\'') != std::string::npos;
  header.names.assign(words.begin() + 4, words.end());
  return header;
}

// The columns of a file without a header, as Emlid's .LLH: those that RTKLIB writes of a solution in latitude,
// longitude and height, in GPS time.
PosHeader usual_header(const TextReader& reader) {
  PosHeader header;
  header.names = {"Q", "ns", "sdn(m)", "sde(m)", "sdu(m)", "sdne(m)", "sdeu(m)", "sdun(m)", "age(s)", "ratio"};
  const std::size_t fields = reader.fields().size(), plain = header.fields();
  constexpr std::size_t kWithVelocities = 9;
  if (fields == plain + kWithVelocities) {
    header.names.insert(header.names.end(),
                        {"vn(m/s)", "ve(m/s)", "vu(m/s)", "sdvn", "sdve", "sdvu", "sdvne", "sdveu", "sdvun"});
  }
  if (fields != header.fields()) {
    refuse(reader, fmt::format("no header line before the first fix, and {} fields, not {} as RTKLIB writes them; set "
                               "out-outhead=on in RTKLIB",
                               fields, plain));
  }
  return header;
}

// The correlations by sdne, sdeu and sdun: each is the square root of a covariance, with its sign. Zero where the
// header does not have all of them.
template <class Value>
Correlation correlations_of(const PosHeader& header, const Value& value) {
  if (!header.find("sdne(m)") || !header.find("sdeu(m)") || !header.find("sdun(m)")) return Correlation::Zero();
  const auto covariance = [&](std::string_view name) { return value(name) * std::abs(value(name)); };
  const double ne = covariance("sdne(m)"), ed = -covariance("sdeu(m)"), nd = -covariance("sdun(m)");
  const Vector3d variance = Vector3d(value("sdn(m)"), value("sde(m)"), value("sdu(m)")).cwiseAbs2();
  Matrix3d all;
  all << variance.x(), ne, nd, ne, variance.y(), ed, nd, ed, variance.z();
  return correlations(all);
}

}  // namespace

GnssRecording read_gnss_rtklib(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kSpaces, log.content);
  GnssRecording gnss{log.file, {}};
  std::optional<PosHeader> header;
  WeekTime times(log.order());
  const auto row = [&] {
    if (reader.line().starts_with('%')) {
      if (auto found = header_of(reader)) header = std::move(found);
      return;
    }
    if (!header) header = usual_header(reader);
    if (reader.fields().size() != header->fields()) {
      reader.fail(fmt::format("{} fields, but the header promises {}; is the line cut?", reader.fields().size(),
                              header->fields()),
                  RowFault::Kind::kFields);
    }
    const auto value = [&](std::string_view name) {
      const auto place = header->find(name);
      if (!place) reader.fail(fmt::format("the header names no column `{}`", name));
      return reader.number(*place);
    };
    std::size_t field = 2;
    const double latitude = angle_of(reader, field, header->sexagesimal);
    const double longitude = angle_of(reader, field, header->sexagesimal);
    if (!has_coordinates(latitude, longitude)) {
      ++gnss.without_fix;
      return;
    }
    GeodeticFix fix;
    fix.time = times.next(time_of(reader, header->system), reader);
    fix.position = geodetic_degrees(latitude, longitude, reader.number(field));
    if (!log.sigma) {
      fix.sigma_position = {value("sdn(m)"), value("sde(m)"), value("sdu(m)")};
      fix.correlation = correlations_of(*header, value);
    }
    if (header->find("vn(m/s)")) {
      const Vector3d sigma{value("sdvn"), value("sdve"), value("sdvu")};
      if (!sigma.isZero(0) || log.sigma_velocity)
        fix.velocity = {{value("vn(m/s)"), value("ve(m/s)"), -value("vu(m/s)")}, sigma};
    }
    if (header->find("Q")) fix.quality = quality_of(reader, value("Q"));
    if (header->find("ns")) fix.satellites = satellites_of(value("ns"));
    check_fix(fix, log, reader);
    gnss.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return gnss;
}

std::optional<GpsTime> first_time_rtklib(const LogFile& log) {
  TextReader reader(log.file, TextReader::Separator::kSpaces, log.content);
  std::optional<PosHeader> header;
  while (reader.next()) {
    try {
      if (reader.line().starts_with('%')) {
        if (auto found = header_of(reader)) header = std::move(found);
      } else if (header && reader.fields().size() == header->fields()) {
        return time_of(reader, header->system);
      }
    } catch (const RowError&) {  // a row without a time, which its reader reports
    }
  }
  return std::nullopt;
}

}  // namespace piste::log_formats
