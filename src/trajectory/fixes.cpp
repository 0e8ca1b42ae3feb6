/// Trajectories from logs of receivers and attitudes, which io reads.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "configuration/column_keys.h"
#include "math/time.h"
#include "piste/configuration/imu_source.h"
#include "piste/io/config.h"
#include "piste/io/log_io.h"
#include "trajectory/formats.h"

namespace piste::trajectory_formats {
namespace {

// Fixes without a stated sigma are read as well; every other fault ends the reading.
std::vector<GeodeticFix> fixes_of(const LogFile& log) {
  RowFaults faults;
  GnssRecording gnss = read_gnss(log, &faults);
  if (!faults.first.empty()) {
    throw DataError(faults.error_at.empty() ? log.file : faults.error_at, faults.first.front().what);
  }
  if (gnss.fixes.empty()) throw DataError(log.file + ":1", "holds no fix");
  return std::move(gnss.fixes);
}

// A log as replay's configuration names it; its sigmas need not be stated.
LogFile mapped(const Config& source, std::initializer_list<LogFormat> formats,
               std::span<const ColumnQuantity> quantities) {
  LogFile log = read_log_file(source, formats);
  if (log.format == LogFormat::kColumns) log.columns = read_column_map(source, quantities);
  return log;
}

// A velocity without down, or a sigma that some row lacks, is left out.
Trajectory track_of(const std::vector<GeodeticFix>& fixes) {
  Trajectory track;
  const auto all = [&](const auto& holds) { return std::all_of(fixes.begin(), fixes.end(), holds); };
  const bool velocity = all([](const GeodeticFix&f) { return f.velocity && f.velocity->has_down(); }),
             sigma = all([](const GeodeticFix&f) { return f.sigma_position.allFinite(); }),
             sigma_velocity = velocity && all([](const GeodeticFix&f) { return f.velocity->sigma.minCoeff() > 0; });
  for (const GeodeticFix& fix : fixes) {
    track.time.push_back(fix.time);
    track.place.push_back(fix.position);
    if (velocity) track.velocity.push_back(fix.velocity->value);
    if (sigma) track.sigma_position.push_back(fix.sigma_position);
    if (sigma_velocity) track.sigma_velocity.push_back(fix.velocity->sigma);
  }
  return track;
}

// The attitudes at the times of the track; rows without one within `kApart` are left out.
void add_attitudes(Trajectory& track, const std::vector<EulerFix>& attitudes) {
  constexpr double kApart = 1e-6;  // s
  Trajectory both;
  std::size_t k = 0;
  for (std::size_t i = 0; i < track.size(); ++i) {
    while (k < attitudes.size() && attitudes[k].time < track.time[i] - kApart) ++k;
    if (k == attitudes.size()) break;
    if (attitudes[k].time > track.time[i] + kApart) continue;
    both.time.push_back(track.time[i]);
    both.place.push_back(track.place[i]);
    both.attitude.push_back(from_euler(attitudes[k].angles));
    if (!track.velocity.empty()) both.velocity.push_back(track.velocity[i]);
    if (!track.sigma_position.empty()) both.sigma_position.push_back(track.sigma_position[i]);
    if (!track.sigma_velocity.empty()) both.sigma_velocity.push_back(track.sigma_velocity[i]);
    if (attitudes[k].sigma.allFinite()) both.sigma_euler.push_back(attitudes[k].sigma);
  }
  if (both.sigma_euler.size() != both.size()) both.sigma_euler.clear();
  track = std::move(both);
}

}  // namespace

bool is_rtklib(const FileStart& start) {
  return start.text.starts_with('%') && start.text.find("latitude(") != std::string_view::npos;
}
bool is_nmea(const FileStart& start) { return start.first_row.starts_with('$') || start.first_row.starts_with('!'); }
bool is_mapping(const FileStart& start) {
  const std::string extension = start.path.extension().string();
  return extension == ".yaml" || extension == ".yml";
}

Trajectory read_rtklib(const std::string& file) {
  return track_of(fixes_of({.file = file, .format = LogFormat::kRtklibPos}));
}

Trajectory read_nmea(const std::string& file) { return track_of(fixes_of({.file = file, .format = LogFormat::kNmea})); }

Trajectory read_mapping(const std::string& file) {
  const Config config = Config::load(file);
  const LogFile places = mapped(config.map("gnss"),
                                {LogFormat::kCsv, LogFormat::kKfGins, LogFormat::kRtklibPos, LogFormat::kNmea,
                                 LogFormat::kUbx, LogFormat::kNovatel, LogFormat::kColumns},
                                gnss_quantities());
  const auto attitude = config.find_map("attitude");
  const auto angles = attitude
                          ? std::optional(mapped(*attitude, {LogFormat::kCsv, LogFormat::kInspva, LogFormat::kColumns},
                                                 attitude_quantities()))
                          : std::nullopt;
  config.finish();
  Trajectory track = track_of(fixes_of(places));
  if (!angles) return track;
  RowFaults faults;
  const AttitudeRecording recording = read_attitude(*angles, &faults);
  if (!faults.first.empty()) {
    throw DataError(faults.error_at.empty() ? angles->file : faults.error_at, faults.first.front().what);
  }
  add_attitudes(track, recording.fixes);
  if (track.time.empty()) {
    throw DataError(angles->file + ":1", fmt::format("no row has the time of a row of {}", places.file));
  }
  return track;
}

}  // namespace piste::trajectory_formats
