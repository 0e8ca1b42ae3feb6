#include "declared_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "column_names.h"
#include "column_values.h"
#include "io/lower_case.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr std::size_t kHead = 16 << 10;  // bytes

// The value of a line `key,value`.
std::optional<std::string_view> value_of(std::string_view head, std::string_view key) {
  TextReader reader("", TextReader::Separator::kComma, head);
  while (reader.next()) {
    if (reader.fields().size() == 2 && reader.fields()[0] == key) return reader.fields()[1];
  }
  return std::nullopt;
}

// Where a column of this axis lies by an orientation such as `YxZ`, which names the sensor's axes along x, y and z, in
// small letters those against them. Empty if it names none.
std::string along(std::string_view orientation, char axis) {
  for (std::size_t i = 0; i < orientation.size(); ++i) {
    const auto letter = static_cast<unsigned char>(orientation[i]);
    if (std::tolower(letter) == axis) return {std::isupper(letter) != 0 ? '+' : '-', "xyz"[i]};
  }
  return {};
}

bool is_orientation(std::string_view text) {
  std::string letters = lower_case(text);
  std::sort(letters.begin(), letters.end());
  return letters == "xyz";
}

void declare_gyroflow(std::string_view head, ColumnTable& table) {
  const auto unit = [&](std::string_view key, std::string_view of) {
    const auto text = value_of(head, key);
    const auto scale = text ? number_in(*text, TextReader::Separator::kComma) : std::nullopt;
    return scale && *scale > 0 ? fmt::format("{:.12g} {}", *scale, of) : std::string();
  };
  std::vector<std::size_t> forces;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    if (meaning_of(table.columns[c]).key == "accel") forces.push_back(c);
  }
  // The scale should be that of g. Some loggers write that of m/s²: the magnitude of gravity decides.
  std::string force = unit("ascale", "g");
  if (forces.size() == 3 && !force.empty()) {
    const double counts = usual_magnitude(table, {forces[0], forces[1], forces[2]});
    const std::string metres = unit("ascale", "m/s^2");
    if (gravity_unit(counts * unit_factor(metres, dimension::kAcceleration)).unit == "m/s^2") force = metres;
  }
  const std::string orientation(value_of(head, "orientation").value_or(""));
  for (SampledColumn& column : table.columns) {
    const ColumnMeaning meaning = meaning_of(column);
    if (meaning.key == "time") column.unit = unit("tscale", "s");
    if (meaning.key == "gyro") column.unit = unit("gscale", "rad/s");
    if (meaning.key == "accel") column.unit = force;
    if ((meaning.key == "gyro" || meaning.key == "accel") && is_orientation(orientation) && orientation != "XYZ")
      column.along = along(orientation, meaning.axis);
  }
}

double largest_of(const SampledColumn& column) {
  double most = 0;
  for (const double v : column.values) most = std::isfinite(v) ? std::max(most, std::abs(v)) : most;
  return most;
}

// Degrees, as other programs write them, would be within three of latitude and longitude zero as minutes.
void declare_vbox(const std::string& head, ColumnTable& table) {
  constexpr double kMostLatitude = 90, kMostLongitude = 180;  // deg
  std::vector<ColumnMeaning> meanings;
  meanings.reserve(table.columns.size());
  for (const SampledColumn& column : table.columns) meanings.push_back(meaning_of(column));
  const auto named = [&](std::string_view key) {
    const auto place = column_of(meanings, key);
    return place ? &table.columns[*place] : nullptr;
  };
  SampledColumn *const latitude = named("latitude"), *const longitude = named("longitude");
  if (latitude != nullptr && longitude != nullptr &&
      (largest_of(*latitude) > kMostLatitude || largest_of(*longitude) > kMostLongitude)) {
    latitude->unit = longitude->unit = "arcmin";
    longitude->along = "west";
  }
  if (SampledColumn* const time = named("time")) time->unit = kTimeOfDay;
  if (SampledColumn* const speed = named("speed"); speed != nullptr && head.find("velocity kmh") != std::string::npos)
    speed->unit = "km/h";
}

// SensorLog, which iOS alone has: its forces have Apple's sign, minus that of the specific force.
void declare_sensorlog(ColumnTable& table) {
  const bool is_it = std::any_of(table.columns.begin(), table.columns.end(), [](const SampledColumn& c) {
    return c.words == std::vector<std::string>{"accelerometer", "timestamp", "since", "reboot"};
  });
  for (SampledColumn& column : table.columns) {
    const ColumnMeaning meaning = meaning_of(column);
    if (is_it && meaning.key == "accel" && column.has("accelerometer")) column.along = {'-', meaning.axis};
  }
}

}  // namespace

void declare_columns(std::string_view text, ColumnTable& table) {
  if (!table.header) return;
  const std::string_view head = text.substr(0, kHead);
  if (head.starts_with("GYROFLOW IMU LOG")) declare_gyroflow(head, table);
  declare_sensorlog(table);
  const std::string lower = lower_case(head);
  if (lower.find("[column names]") != std::string::npos && lower.find("[data]") != std::string::npos)
    declare_vbox(lower, table);
}

}  // namespace piste
