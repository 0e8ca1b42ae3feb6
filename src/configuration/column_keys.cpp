#include "configuration/column_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <stdexcept>

#include "io/column_axes.h"

namespace piste {
namespace {

constexpr std::array kImu = std::to_array<ColumnQuantity>({{"gyro", dimension::kAngularRate, 3, 3},
                                                           {"accel", dimension::kAcceleration, 3, 3},
                                                           {"dtheta", dimension::kAngle, 3, 3},
                                                           {"dvel", dimension::kVelocity, 3, 3},
                                                           {"magnetic", dimension::kMagneticField, 3, 3},
                                                           {"temperature", dimension::kTemperature, 1, 1}});
constexpr std::array kGnss = std::to_array<ColumnQuantity>({{"latitude", dimension::kAngle, 1, 1},
                                                            {"longitude", dimension::kAngle, 1, 1},
                                                            {"height", dimension::kLength, 1, 1},
                                                            {"sigma", dimension::kLength, 3, 3},
                                                            {"covariance", dimension::kArea, 9, 9},
                                                            {"horizontal_accuracy", dimension::kLength, 1, 1},
                                                            {"vertical_accuracy", dimension::kLength, 1, 1},
                                                            {"velocity", dimension::kVelocity, 2, 3},
                                                            {"sigma_velocity", dimension::kVelocity, 1, 3},
                                                            {"speed", dimension::kVelocity, 1, 1},
                                                            {"course", dimension::kAngle, 1, 1},
                                                            {"speed_accuracy", dimension::kVelocity, 1, 1},
                                                            {"course_accuracy", dimension::kAngle, 1, 1},
                                                            {"fix", dimension::kRatio, 1, 1},
                                                            {"quality", dimension::kRatio, 1, 1}});
constexpr std::array kAttitude =
    std::to_array<ColumnQuantity>({{"angles", dimension::kAngle, 3, 3}, {"sigma", dimension::kAngle, 3, 3}});

constexpr std::array<std::pair<std::string_view, TimeScale>, 5> kScales{{{"boot", TimeScale::kBoot},
                                                                         {"gps_week", TimeScale::kGpsWeek},
                                                                         {"gps", TimeScale::kGps},
                                                                         {"utc", TimeScale::kUtc},
                                                                         {"unix", TimeScale::kUtc}}};
constexpr std::array<std::pair<std::string_view, Delimiter>, 7> kDelimiters{{{"comma", Delimiter::kComma},
                                                                             {",", Delimiter::kComma},
                                                                             {"semicolon", Delimiter::kSemicolon},
                                                                             {";", Delimiter::kSemicolon},
                                                                             {"tab", Delimiter::kTab},
                                                                             {"\t", Delimiter::kTab},
                                                                             {"blanks", Delimiter::kBlanks}}};

// The key `unit`, which must measure this.
std::string read_unit(const Config& map, const Dimension& dimension) {
  std::string unit = map.text("unit", "");
  if (unit.empty()) return unit;
  try {
    unit_factor(unit, dimension);
  } catch (const std::invalid_argument& e) {
    map.fail("unit", e.what());
  }
  return unit;
}

ColumnTime read_time(const Config& map, TimeScale scale) {
  ColumnTime time;
  time.name = map.text("name");
  time.of = map.choice<TimeScale>("of", kScales, scale);
  time.week = map.text("week", "");
  time.date = map.text("date", "");
  time.unit = map.text("unit", "");
  const bool digits = time.unit == "hhmmss";
  if (digits && time.of != TimeScale::kBoot) {
    map.fail("unit", "hhmmss is a time of an unknown day: `of: boot`; with a column of the date, `unit: calendar`");
  }
  const bool days = time.unit == kDatenum || time.unit == kSheetDays;
  if (days && time.of != TimeScale::kUtc && time.of != TimeScale::kGps)
    map.fail("unit", fmt::format("{} is a date and a time: `of: utc` or `of: gps`", time.unit));
  if (time.unit != "calendar" && !digits && !days) time.unit = read_unit(map, dimension::kTime);
  if (!time.week.empty() && time.of != TimeScale::kGpsWeek)
    map.fail("week", "goes with seconds of week: `of: gps_week`");
  const bool calendar = time.unit == "calendar";
  if (calendar && time.of != TimeScale::kUtc && time.of != TimeScale::kGps) {
    map.fail("unit", "calendar times are `of: utc` or `of: gps`");
  }
  if (const auto rest = map.find_map("rest")) {
    time.rest = rest->text("name");
    time.rest_unit = read_unit(*rest, dimension::kTime);
    if (calendar) map.fail("rest", "goes with a number, not with a calendar time");
  }
  if (!time.date.empty() && !calendar) map.fail("date", "goes with a time of day: `unit: calendar`");
  return time;
}

std::vector<ColumnRows> read_rows(const Config& map) {
  std::vector<ColumnRows> all;
  if (!map.has("rows")) return all;
  for (const Config& rows : map.maps("rows")) all.push_back({rows.text("name"), rows.text("is")});
  return all;
}

// The directions along which columns lie: one of each pair for each column, where a third may be missing.
std::vector<std::string> read_axes(const Config& map, std::size_t columns, std::span<const AxisNames, 3> names,
                                   std::string_view example) {
  std::vector<std::string> axes = map.words("axes");
  std::array<std::size_t, 3> found{};
  for (std::string& axis : axes) {
    if (axis == "x" || axis == "y" || axis == "z") axis = fmt::format("+{}", axis);
    const auto name =
        std::find_if(names.begin(), names.end(), [&](const AxisNames& n) { return axis == n[0] || axis == n[1]; });
    if (name == names.end()) map.fail("axes", fmt::format("`{}` is no axis; right would be `{}`", axis, example));
    ++found[static_cast<std::size_t>(name - names.begin())];
  }
  const bool each = found[0] == 1 && found[1] == 1 && found[2] + 2 == columns;
  if (!axes.empty() && (axes.size() != columns || !each)) {
    map.fail("axes", fmt::format("one axis for each column is expected, such as `{}`", example));
  }
  return axes;
}

// The direction in which a latitude or longitude grows.
std::vector<std::string> read_growth(const Config& map, const AxisNames& names, bool lettered) {
  std::vector<std::string> axes = map.words("axes");
  if (lettered) map.fail("axes", "goes with a column with signs, not with `hemisphere`");
  if (axes.size() != 1 || std::find(names.begin(), names.end(), axes[0]) == names.end()) {
    map.fail("axes", fmt::format("right would be `{}` or `{}`, the direction in which it grows", names[0], names[1]));
  }
  return axes;
}

ColumnUse read_use(const Config& columns, const ColumnQuantity& quantity) {
  const Config map = columns.map(quantity.key);
  ColumnUse use;
  if (map.has("name")) {
    use.names.push_back(map.text("name"));
  } else {
    use.names = map.words("names");
  }
  if (use.names.size() < quantity.least || use.names.size() > quantity.most) {
    columns.fail(quantity.key, quantity.most == 1 ? std::string("one column is expected, such as `{name: …, unit: …}`")
                                                  : fmt::format("{} columns are named, but {} are expected, such as "
                                                                "`{{names: [x, y, z], unit: …}}`",
                                                                use.names.size(), quantity.most));
  }
  const std::string_view key = quantity.key;
  const bool place = key == "latitude" || key == "longitude";
  const bool minutes = place && map.text("unit", "") == kDegreesMinutes;
  if (minutes) use.unit = kDegreesMinutes;
  if (!minutes) use.unit = read_unit(map, quantity.dimension);
  const bool level =
      key == "velocity" || key == "sigma_velocity" || (key == "sigma" && quantity.dimension == dimension::kLength);
  const bool triad = key == "gyro" || key == "accel" || key == "dtheta" || key == "dvel" || key == "magnetic";
  if (level) use.axes = read_axes(map, use.names.size(), kLevelAxes, "east north up");
  if (key == "covariance") use.axes = read_axes(map, 3, kLevelAxes, "east north up");
  if (triad) use.axes = read_axes(map, use.names.size(), kSensorAxes, "+x -y -z");
  if (key == "accel" && map.has("added")) {
    use.added = map.words("added");
    if (use.added.size() != use.names.size()) map.fail("added", "three columns are expected, those of gravity");
  }
  if (place) use.hemisphere = map.text("hemisphere", "");
  if (place && map.has("axes"))
    use.axes = read_growth(map, kLevelAxes[key == "latitude" ? 0 : 1], !use.hemisphere.empty());
  if (key == "height") use.geoid = map.text("geoid", "");
  if (key == "quality")
    use.of = map.choice<std::string>("of", {{"words", ""}, {"nmea", "nmea"}, {"rtklib", "rtklib"}}, "");
  if (key == "fix") {
    for (const std::string& value : map.words("valid")) {
      try {
        use.valid.push_back(parse_quantity(value, dimension::kRatio));
      } catch (const std::invalid_argument& e) {
        map.fail("valid", e.what());
      }
    }
  }
  return use;
}

// Throws if the mapping lacks the quantities that a log needs.
void require(const Config& columns, const ColumnMap& map, std::span<const ColumnQuantity> quantities) {
  const auto need = [&](std::initializer_list<std::string_view> keys, std::string_view example) {
    for (const std::string_view key : keys) {
      if (map.find(key) == nullptr)
        columns.fail({}, fmt::format("columns: `{}` is missing, such as `{}: {}`", key, key, example));
    }
  };
  constexpr std::string_view kThree = "{names: [x, y, z], unit: …}", kOne = "{name: …, unit: …}";
  if (quantities.data() == kImu.data()) {
    const bool increments = map.find("dtheta") != nullptr || map.find("dvel") != nullptr;
    if (increments && (map.find("gyro") != nullptr || map.find("accel") != nullptr)) {
      columns.fail({}, "columns: either rates are named, gyro and accel, or increments, dtheta and dvel");
    }
    increments ? need({"dtheta", "dvel"}, kThree) : need({"gyro", "accel"}, kThree);
  } else if (quantities.data() == kGnss.data()) {
    need({"latitude", "longitude", "height"}, kOne);
    if (map.find("speed") != nullptr || map.find("course") != nullptr) {
      need({"speed", "course"}, kOne);
      if (map.find("velocity") != nullptr) columns.fail({}, "columns: either `velocity` is named, or speed and course");
    }
    if (map.find("sigma") == nullptr &&
        (map.find("horizontal_accuracy") != nullptr || map.find("vertical_accuracy") != nullptr)) {
      need({"horizontal_accuracy", "vertical_accuracy"}, kOne);
    }
  } else {
    need({"angles"}, "{names: [roll, pitch, heading], unit: deg}");
  }
}

std::string plain_or_quoted(const std::string& text) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
  };
  return !text.empty() && std::all_of(text.begin(), text.end(), plain) ? text : yaml_text(text);
}

std::string text_of(const ColumnTime& time) {
  std::string text = "{name: " + plain_or_quoted(time.name);
  if (!time.week.empty()) text += ", week: " + plain_or_quoted(time.week);
  if (!time.date.empty()) text += ", date: " + plain_or_quoted(time.date);
  if (!time.unit.empty()) text += ", unit: " + time.unit;
  if (!time.rest.empty()) {
    text += fmt::format(", rest: {{name: {}{}}}", plain_or_quoted(time.rest),
                        time.rest_unit.empty() ? "" : ", unit: " + time.rest_unit);
  }
  return text + fmt::format(", of: {}}}", name_of(time.of));
}

std::string text_of(const std::vector<ColumnRows>& rows) {
  std::vector<std::string> all;
  all.reserve(rows.size());
  for (const ColumnRows& r : rows)
    all.push_back(fmt::format("{{name: {}, is: {}}}", plain_or_quoted(r.name), plain_or_quoted(r.is)));
  return all.size() == 1 ? all[0] : fmt::format("[{}]", fmt::join(all, ", "));
}

std::string text_of(const ColumnUse& use) {
  std::vector<std::string> names;
  for (const std::string& name : use.names) names.push_back(plain_or_quoted(name));
  std::string text = names.size() == 1 ? "{name: " + names[0] : fmt::format("{{names: [{}]", fmt::join(names, ", "));
  if (!use.added.empty()) {
    std::vector<std::string> added;
    added.reserve(use.added.size());
    for (const std::string& name : use.added) added.push_back(plain_or_quoted(name));
    text += fmt::format(", added: [{}]", fmt::join(added, ", "));
  }
  if (!use.geoid.empty()) text += ", geoid: " + plain_or_quoted(use.geoid);
  if (!use.hemisphere.empty()) text += ", hemisphere: " + plain_or_quoted(use.hemisphere);
  if (!use.axes.empty()) text += fmt::format(", axes: {}", fmt::join(use.axes, " "));
  if (!use.unit.empty()) text += ", unit: " + plain_or_quoted(use.unit);
  if (!use.of.empty()) text += ", of: " + use.of;
  if (!use.valid.empty()) text += fmt::format(", valid: [{}]", fmt::join(use.valid, ", "));
  return text + "}";
}

}  // namespace

std::span<const ColumnQuantity> imu_quantities() { return kImu; }
std::span<const ColumnQuantity> gnss_quantities() { return kGnss; }
std::span<const ColumnQuantity> attitude_quantities() { return kAttitude; }

std::string_view name_of(TimeScale scale) {
  return std::find_if(kScales.begin(), kScales.end(), [scale](const auto& s) { return s.second == scale; })->first;
}

ColumnMap read_column_map(const Config& source, std::span<const ColumnQuantity> quantities) {
  if (!source.has("columns")) {
    source.fail("format", "columns needs the key `columns:`, which says where the values stand; `inspect` writes it");
  }
  const Config columns = source.map("columns");
  ColumnMap map;
  map.time = read_time(columns.map("time"), TimeScale::kBoot);
  for (const ColumnQuantity& quantity : quantities) {
    if (!columns.has(quantity.key)) continue;
    map.uses.emplace(quantity.key, read_use(columns, quantity));
    if (quantity.key != "accel") continue;
    const Config accel = columns.map("accel");
    if (const auto time = accel.find_map("time")) map.accel_time = read_time(*time, map.time.of);
    map.accel_rows = read_rows(accel);
  }
  map.rows = read_rows(columns);
  if (quantities.data() == kGnss.data()) map.only_new = columns.flag("only_new", false);
  require(columns, map, quantities);
  if (source.has("delimiter")) map.delimiter = source.choice<Delimiter>("delimiter", kDelimiters);
  if (source.has("skip")) {
    const long skip = source.integer("skip");
    if (skip < 0) source.fail("skip", "the number of lines above the header is expected");
    map.skip = static_cast<std::size_t>(skip);
  }
  if (source.has("header")) map.header = source.flag("header");
  return map;
}

std::string columns_text(const ColumnMap& map, std::string_view indent) {
  std::string text = "{time: " + text_of(map.time);
  if (!map.rows.empty()) text += fmt::format(",\n{}rows: {}", indent, text_of(map.rows));
  std::vector<std::string_view> written;  // `sigma` is a key of receivers and of attitudes
  for (const auto quantities : {imu_quantities(), gnss_quantities(), attitude_quantities()}) {
    for (const ColumnQuantity& quantity : quantities) {
      const ColumnUse* use = map.find(quantity.key);
      if (use == nullptr || std::find(written.begin(), written.end(), quantity.key) != written.end()) continue;
      written.push_back(quantity.key);
      std::string entry = text_of(*use);
      if (quantity.key == "accel" && map.accel_time) {
        entry.insert(entry.size() - 1, ", time: " + text_of(*map.accel_time));
      }
      if (quantity.key == "accel" && !map.accel_rows.empty()) {
        entry.insert(entry.size() - 1, ", rows: " + text_of(map.accel_rows));
      }
      text += fmt::format(",\n{}{}: {}", indent, quantity.key, entry);
    }
  }
  if (map.only_new) text += fmt::format(",\n{}only_new: true", indent);
  return text + "}";
}

}  // namespace piste
