#include "row_kinds.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "column_names.h"
#include "column_values.h"
#include "io/lower_case.h"

namespace piste {
namespace {

constexpr std::size_t kMostKinds = 40;  // autopilots have as many messages
constexpr std::size_t kMostImus = 8;    // IMUs that are numbered

// Whether a text is the name of an IMU, or of its gyroscopes. Words such as `gps` may instead state the source of a
// position.
bool names_body(const std::string& text) {
  const std::string lower = lower_case(text);
  return lower.find("gyr") != std::string::npos || lower.find("imu") != std::string::npos;
}

// The texts of a column with the number of their rows; empty if a row has none, or if they are too many.
std::map<std::string, std::size_t> kinds_of(const SampledColumn& column) {
  std::map<std::string, std::size_t> kinds;
  for (const std::string_view text : column.texts) {
    ++kinds[std::string(text)];
    if (text.empty() || kinds.size() > kMostKinds) return {};
  }
  return kinds;
}

// Whether the numbers of a column are those of several IMUs with columns in the same table.
bool numbers_units(const ColumnTable& table, const SampledColumn& column,
                   const std::map<std::string, std::size_t>& kinds) {
  constexpr std::size_t kLeastPart = 20;  // of the rows, one in so many
  constexpr double kTurns = 0.2;          // of the rows, that part is of another than the one before
  const bool named = column.has_any({"i", "id", "imu", "instance", "sensor", "device"});
  const auto measures = [&](std::string_view key) {
    return std::any_of(table.columns.begin(), table.columns.end(),
                       [&](const SampledColumn& c) { return meaning_of(c).key == key; });
  };
  return named && column.is_whole() && changing(table, column) > kTurns && kinds.size() <= kMostImus &&
         measures("gyro") && measures("accel") &&
         std::all_of(kinds.begin(), kinds.end(), [&](const auto& k) { return kLeastPart * k.second > table.rows; });
}

}  // namespace

std::optional<RowKinds> row_kinds(const ColumnTable& table) {
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const SampledColumn& column = table.columns[c];
    const auto kinds = kinds_of(column);
    if (kinds.size() < 2) continue;
    const bool text =
        std::none_of(column.values.begin(), column.values.end(), [](double v) { return std::isfinite(v); });
    const bool bodies = std::any_of(kinds.begin(), kinds.end(), [](const auto& k) { return names_body(k.first); });
    if (!(text ? bodies : numbers_units(table, column, kinds))) continue;
    RowKinds found{c, {}, !text};
    for (const auto& [kind, count] : kinds) found.kinds.push_back(kind);
    return found;
  }
  return std::nullopt;
}

}  // namespace piste
