/// Text that NovAtel's Inertial Explorer exports: lines of a heading, a line of names, a line of units in brackets.

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "io/text_reader.h"
#include "math/time.h"
#include "piste/core/error.h"
#include "piste/math/units.h"
#include "trajectory/formats.h"

namespace piste::trajectory_formats {
namespace {

bool has_word(std::string_view line, std::string_view word) { return line.find(word) != std::string_view::npos; }

bool is_header(std::string_view line) { return has_word(line, "Latitude") && has_word(line, "Longitude"); }

// Names in lower case without marks, so that `SD-VE`, `SDVE` and `sd_ve` are one.
std::string plain(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) out += static_cast<char>(std::tolower(c));
  }
  return out;
}

// The columns: an angle in degrees, minutes and seconds takes three fields.
class Columns {
 public:
  Columns(const TextReader& header) {
    for (const std::string_view name : header.fields()) names_.push_back(plain(name));
  }
  void take_units(const TextReader& reader) {
    // (D M S) stands in brackets with blanks between.
    std::string_view line = reader.line();
    for (std::size_t at = line.find('('), column = 0; at != std::string_view::npos; ++column) {
      const std::size_t end = std::min(line.find(')', at), line.size());
      const std::string_view unit = line.substr(at + 1, end - at - 1);
      widths_.push_back(has_word(unit, "D M S") || has_word(unit, "D:M:S") ? 3 : 1);
      units_.emplace_back(unit);
      at = line.find('(', end);
    }
    if (units_.size() != names_.size()) {
      reader.fail(fmt::format("{} units in brackets, but {} names above them; one a column is expected", units_.size(),
                              names_.size()));
    }
  }
  std::size_t fields() const {
    std::size_t sum = 0;
    for (const std::size_t width : widths_) sum += width;
    return sum;
  }
  std::optional<std::size_t> find(std::initializer_list<std::string_view> names) const {
    for (const std::string_view name : names) {
      const auto place = std::find(names_.begin(), names_.end(), name);
      if (place != names_.end()) return static_cast<std::size_t>(place - names_.begin());
    }
    return std::nullopt;
  }
  std::size_t require(const TextReader& reader, std::initializer_list<std::string_view> names) const {
    if (const auto column = find(names)) return *column;
    throw DataError(reader.where(),
                    fmt::format("column {} is missing; let Inertial Explorer export it", *names.begin()));
  }
  // In SI and radians.
  double value(const TextReader& reader, std::size_t column) const {
    std::size_t field = 0;
    for (std::size_t i = 0; i < column; ++i) field += widths_[i];
    if (widths_[column] == 3) {
      const double sign = reader.fields()[field].starts_with('-') ? -1 : 1;
      return kDegree * sign *
             (std::abs(reader.number(field)) + reader.number(field + 1) / 60 + reader.number(field + 2) / kHour);
    }
    const std::string& unit = units_[column];
    const double factor = has_word(unit, "arcmin")                         ? kDegree / 60
                          : has_word(unit, "arcsec")                       ? kDegree / kHour
                          : has_word(unit, "deg") || has_word(unit, "Deg") ? kDegree
                                                                           : 1;
    return factor * reader.number(field);
  }
  bool is_of(std::size_t column, std::string_view unit) const { return has_word(units_[column], unit); }

 private:
  std::vector<std::string> names_, units_;
  std::vector<std::size_t> widths_;
};

using Three = std::optional<std::array<std::size_t, 3>>;

Three find_columns(const Columns& columns, std::initializer_list<std::string_view> first,
                   std::initializer_list<std::string_view> second, std::initializer_list<std::string_view> third) {
  const auto a = columns.find(first), b = columns.find(second), c = columns.find(third);
  if (!a || !b || !c) return std::nullopt;
  return {{*a, *b, *c}};
}

}  // namespace

bool is_inertial_explorer(const FileStart& start) {
  const std::size_t at = start.text.find("Latitude");
  if (at == std::string_view::npos) return false;
  const std::size_t from = start.text.rfind('\n', at) + 1;
  return is_header(start.text.substr(from, std::min(start.text.find('\n', at), start.text.size()) - from)) &&
         start.text.find('(', at) != std::string_view::npos;
}

Trajectory read_inertial_explorer(const std::string& file) {
  TextReader reader(file, TextReader::Separator::kSpaces);
  std::optional<Columns> columns;
  while (!columns && reader.next()) {
    if (is_header(reader.line())) columns.emplace(reader);
  }
  if (!columns || !reader.next()) throw DataError(file + ":1", "no line that names Latitude and Longitude");
  columns->take_units(reader);
  const auto time = columns->require(reader, {"gpstime", "gpssec", "sow", "time", "sec"}),
             latitude = columns->require(reader, {"latitude"}), longitude = columns->require(reader, {"longitude"}),
             height = columns->require(reader, {"hell", "ellheight", "height"});
  const Three velocity = find_columns(*columns, {"vnorth", "vn"}, {"veast", "ve"}, {"vup", "vu", "vh"}),
              angles = find_columns(*columns, {"roll"}, {"pitch"}, {"heading", "azimuth", "hdng"}),
              sigma = find_columns(*columns, {"sdnorth", "sdn"}, {"sdeast", "sde"}, {"sdheight", "sdh", "sdup", "sdu"}),
              sigma_velocity = find_columns(*columns, {"sdvn"}, {"sdve"}, {"sdvh", "sdvu", "sdvup"}),
              sigma_angles = find_columns(*columns, {"rollsd", "sdroll"}, {"pitchsd", "sdpitch", "ptchsd"},
                                          {"hdngsd", "headingsd", "sdheading", "sdhdng"});
  Trajectory track;
  IncreasingTime increasing;
  const auto three = [&](const Three& of) {
    return Vector3d(columns->value(reader, (*of)[0]), columns->value(reader, (*of)[1]),
                    columns->value(reader, (*of)[2]));
  };
  while (reader.next()) {
    if (reader.fields().size() != columns->fields()) {
      if (track.time.empty()) continue;  // a line below the units
      reader.fail(fmt::format("{} fields, but the header promises {}; is the line cut?", reader.fields().size(),
                              columns->fields()),
                  RowFault::Kind::kFields);
    }
    track.time.push_back(increasing.next(columns->value(reader, time), reader));
    track.place.push_back(
        {columns->value(reader, latitude), columns->value(reader, longitude), columns->value(reader, height)});
    const Vector3d up(1, 1, -1);
    if (velocity) track.velocity.emplace_back(three(velocity).cwiseProduct(up));
    if (angles) track.attitude.push_back(from_euler(three(angles)));
    if (sigma) track.sigma_position.push_back(three(sigma));
    if (sigma_velocity) track.sigma_velocity.push_back(three(sigma_velocity));
    if (sigma_angles) track.sigma_euler.push_back(three(sigma_angles));
  }
  return track;
}

}  // namespace piste::trajectory_formats
