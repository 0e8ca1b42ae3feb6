/// Recordings as columns of numpy, named as those of csv.

#include "recordings.h"

#include <fmt/format.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "bindings.h"
#include "interruptible.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/search/inspect.h"

namespace piste::python {
namespace {

constexpr std::array<std::string_view, 3> kXyz{"x", "y", "z"}, kNed{"north", "east", "down"},
    kEuler{"roll", "pitch", "heading"};

void put(nb::dict& table, const std::string& name, std::vector<double> values) {
  table[name.c_str()] = owned(std::move(values));
}

// The result of `value` for each item.
template <class Items, class Value>
void put(nb::dict& table, const std::string& name, const Items& items, Value&& value) {
  std::vector<double> numbers;
  numbers.reserve(items.size());
  for (const auto& item : items) numbers.push_back(value(item));
  put(table, name, std::move(numbers));
}

// Three columns.
template <class Items, class Value>
void put(nb::dict& table, std::string_view pattern, const std::array<std::string_view, 3>& axes, const Items& items,
         Value&& value) {
  for (int axis = 0; axis < 3; ++axis) {
    put(table, fmt::format(fmt::runtime(pattern), axes[static_cast<std::size_t>(axis)]), items,
        [&](const auto& item) { return value(item)(axis); });
  }
}

// A fault of a log as an error, with its place as a separate member.
DataError error_of(const Suspicion& found) {
  const std::size_t place = found.what.starts_with(found.file) ? found.what.find(": ") : std::string::npos;
  if (place == std::string::npos) return DataError(found.file, found.what);
  return DataError(found.what.substr(0, place), found.what.substr(place + 2));
}

}  // namespace

nb::dict table_of(const ImuRecording& imu) {
  nb::dict table;
  const auto same = [](const Vector3d& v) { return v; };
  put(table, "time_s", imu.time);
  put(table, imu.increments ? "dtheta_{}_rad" : "gyro_{}_rad_s", kXyz, imu.gyro, same);
  put(table, imu.increments ? "dvel_{}_m_s" : "accel_{}_m_s2", kXyz, imu.accel, same);
  if (!imu.magnetic.empty()) put(table, "mag_{}_uT", kXyz, imu.magnetic, same);
  if (!imu.temperature.empty()) put(table, "temperature_degC", imu.temperature);
  return table;
}

nb::dict table_of(const GnssRecording& gnss) {
  nb::dict table;
  const auto& fixes = gnss.fixes;
  put(table, "time_s", fixes, [](const GeodeticFix& f) { return f.time; });
  put(table, "latitude_deg", fixes, [](const GeodeticFix& f) { return kDegreesPerRadian * f.position.latitude; });
  put(table, "longitude_deg", fixes, [](const GeodeticFix& f) { return kDegreesPerRadian * f.position.longitude; });
  put(table, "height_m", fixes, [](const GeodeticFix& f) { return f.position.height; });
  put(table, "sigma_{}_m", kNed, fixes, [](const GeodeticFix& f) { return f.sigma_position; });
  const bool moves = std::any_of(fixes.begin(), fixes.end(), [](const GeodeticFix& f) { return f.velocity; });
  if (!moves) return table;
  const Vector3d none = Vector3d::Constant(kNaN);
  put(table, "velocity_{}_m_s", kNed, fixes,
      [&](const GeodeticFix& f) { return f.velocity ? f.velocity->value : none; });
  put(table, "sigma_velocity_{}_m_s", kNed, fixes,
      [&](const GeodeticFix& f) { return f.velocity ? f.velocity->sigma : none; });
  return table;
}

nb::dict table_of(const AttitudeRecording& attitude) {
  nb::dict table;
  put(table, "time_s", attitude.fixes, [](const EulerFix& f) { return f.time; });
  put(table, "{}_deg", kEuler, attitude.fixes,
      [](const EulerFix& f) { return Vector3d(kDegreesPerRadian * f.angles); });
  put(table, "sigma_{}_deg", kEuler, attitude.fixes,
      [](const EulerFix& f) { return Vector3d(kDegreesPerRadian * f.sigma); });
  return table;
}

void bind_recordings(nb::module_& m) {
  m.def(
      "read",
      [](const std::vector<std::string>& files) {
        struct Read {
          ImuRecording imu;
          GnssRecording gnss;
          AttitudeRecording attitude;
          LogKind kind;
        };
        const Read read = interruptible(nb::none(), [&](Told&) {
          std::vector<Suspicion> found;
          const std::vector<InspectedLog> logs = recognise(files, found);
          if (logs.size() != 1) throw ConfigError(files.front(), "these are several logs; read one at a time");
          if (!logs.front().guess) {
            if (found.empty()) throw DataError(files.front(), "is no log of a known format");
            throw error_of(found.front());
          }
          const LogFile& log = logs.front().log;
          Read out{.imu = {}, .gnss = {}, .attitude = {}, .kind = logs.front().guess->kind};
          if (out.kind == LogKind::kImu) out.imu = read_imu(log);
          if (out.kind == LogKind::kGnss) out.gnss = read_gnss(log);
          if (out.kind == LogKind::kAttitude) out.attitude = read_attitude(log);
          return out;
        });
        if (read.kind == LogKind::kImu) return std::pair<std::string, nb::dict>("imu", table_of(read.imu));
        if (read.kind == LogKind::kGnss) return std::pair<std::string, nb::dict>("gnss", table_of(read.gnss));
        return std::pair<std::string, nb::dict>("attitude", table_of(read.attitude));
      },
      nb::arg("files"), "Kind and columns of a log, whose format is guessed.");
}

}  // namespace piste::python
