#include "piste/configuration/imu_source.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "configuration/column_keys.h"
#include "io/text_reader.h"
#include "piste/configuration/sensor_file.h"
#include "piste/core/error.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// Throws if a hundredth or more of the rows are far beyond the sensor's range: then degrees were declared as radians,
// or the sensor file is that of another sensor. Single glitches pass here, and are marked as clipped later.
void check_range(const ImuRecording& imu, double range) {
  constexpr double kBeyond = 1.5, kPart = 0.01;
  if (range == 0) return;
  std::size_t beyond = 0, first = 0;
  for (std::size_t i = imu.increments ? 1 : 0; i < imu.time.size(); ++i) {
    const double interval = imu.increments ? imu.time[i] - imu.time[i - 1] : 1;
    if (imu.gyro[i].cwiseAbs().maxCoeff() <= kBeyond * range * interval) continue;
    if (beyond++ == 0) first = i;
  }
  if (beyond < 2 || static_cast<double>(beyond) < kPart * static_cast<double>(imu.time.size())) return;
  const double largest =
      imu.gyro[first].cwiseAbs().maxCoeff() / (imu.increments && first > 0 ? imu.time[first] - imu.time[first - 1] : 1);
  throw DataError(
      imu.file,
      fmt::format("{} of {} angular rates are beyond the sensor's range of {:.4g} deg/s, the first "
                  "with {:.4g} deg/s at t = {:.3f} s; are they degrees, to be named gyro_x_deg_s "
                  "or dtheta_x_deg, or is `range` in the sensor file that of another sensor?",
                  beyond, imu.time.size(), kDegreesPerRadian * range, kDegreesPerRadian * largest, imu.time[first]));
}

// Reads the key `steps`: pairs of the log time of the last row before a step, and what the clock jumped.
void read_clock_steps(const Config& clock, LogFile& log) {
  for (const auto& [time, step] : clock.pairs("steps", dimension::kTime)) {
    if (step == 0)
      clock.fail("steps", fmt::format("[{}, {}]: what the clock jumped is expected, such as -0.7 s", time, step));
    log.clock_steps.push_back({time, step});
  }
}

std::string path_at(const Config& source, std::string_view key, DataFile data) {
  return (data == DataFile::kMustExist ? source.existing_file(key) : source.path(key)).string();
}

}  // namespace

bool is_same_log(const std::string& a, const std::string& b) {
  std::error_code missing;
  if (a == b || std::filesystem::equivalent(a, b, missing)) return true;
  if (std::filesystem::file_size(a, missing) != std::filesystem::file_size(b, missing) || missing) return false;
  return MappedFile(a).text() == MappedFile(b).text();
}

void refuse_repeated(const Config& source, const LogFile& log, const LogFile& other) {
  if (!is_same_log(log.file, other.file)) return;
  source.fail("file", fmt::format("is the log of another entry as well, `{}`, or a copy of it, and would count twice; "
                                  "name each log once",
                                  other.file));
}

LogFile read_log_file(const Config& source, std::initializer_list<LogFormat> formats, DataFile data) {
  LogFile log;
  if (const NumberColumns* table = source.table("file")) {
    log.table = *table;
    log.file = source.text("file");
  } else {
    log.file = path_at(source, "file", data);
  }
  std::vector<std::pair<std::string_view, LogFormat>> named;
  for (const LogFormat format : formats) named.emplace_back(name_of(format), format);
  log.format = source.choice<LogFormat>("format", named, LogFormat::kCsv);
  if (log.table && log.format != LogFormat::kCsv) {
    source.fail("format", "a table in memory has columns named as those of csv; leave `format` out");
  }
  log.repair = source.flag("repair", false);
  const bool names_columns = log.format == LogFormat::kCsv || log.format == LogFormat::kXsensAscii;
  if (names_columns) log.ignore_columns = source.words("ignore_columns");
  return log;
}

ImuSource read_imu_source(const Config& imu, DataFile data) {
  ImuSource source;
  source.where = imu.where();
  source.log = read_log_file(imu,
                             {LogFormat::kCsv, LogFormat::kKfGins, LogFormat::kXsensAscii, LogFormat::kImr,
                              LogFormat::kNovatel, LogFormat::kColumns},
                             data);
  if (source.log.format == LogFormat::kColumns) {
    source.log.columns = read_column_map(imu, imu_quantities());
    if (imu.has("accel_file")) source.log.accel_file = path_at(imu, "accel_file", data);
    if (imu.has("gravity_file")) source.log.gravity_file = path_at(imu, "gravity_file", data);
    const ColumnUse* accel = source.log.columns->find("accel");
    if (!source.log.gravity_file.empty() &&
        (source.log.accel_file.empty() || accel == nullptr || accel->added.empty())) {
      imu.fail("gravity_file",
               "its columns are those of `added` under `accel`, and are added to those of `accel_file`; name both");
    }
    const bool apart = source.log.columns->accel_time || !source.log.columns->accel_rows.empty();
    if (apart && source.log.accel_file.empty()) {
      imu.fail("columns",
               "`time` and `rows` under `accel` are of the rows of `accel_file`, which may be the same file");
    }
    if (!source.log.accel_file.empty() && source.log.columns->find("dtheta") != nullptr) {
      imu.fail("accel_file", "increments stand in one file; rates, gyro and accel, may stand in two");
    }
  }
  source.sensor = imu.is_map("sensor") ? read_sensor(imu.map("sensor")) : read_sensor(sensor_file(imu, "sensor"));
  source.conditioning.R_bs = imu.axes("axes");
  source.conditioning.instantaneous = imu.choice<bool>("sampling", {{"mean", false}, {"instant", true}}, false);
  enum class Stamps { kEven, kAsLogged, kShared };
  const auto stamps = imu.choice<Stamps>(
      "stamps", {{"even", Stamps::kEven}, {"as_logged", Stamps::kAsLogged}, {"shared", Stamps::kShared}},
      Stamps::kEven);
  source.log.even_stamps = stamps != Stamps::kAsLogged;
  source.log.shared_stamps = stamps == Stamps::kShared;
  source.log.instant = source.conditioning.instantaneous;
  if (source.conditioning.instantaneous) source.where = imu.where("sampling");
  if (const auto clock = imu.find_map("clock")) {
    source.conditioning.clock_offset = clock->quantity("offset", dimension::kTime, 0);
    source.conditioning.clock_drift = clock->quantity("drift", dimension::kRatio, 0);
    if (std::abs(source.conditioning.clock_drift) > 0.01)
      clock->fail("drift", "a clock is off by ppm, such as `20 ppm`");
    read_clock_steps(*clock, source.log);
  }
  return source;
}

ImuRecording read_imu(const ImuSource& source) {
  ImuRecording imu = read_imu(source.log);
  if (imu.increments && source.conditioning.instantaneous) {
    throw ConfigError(source.where, fmt::format("sampling: {} holds increments, which are no instantaneous samples; "
                                                "leave `sampling` out",
                                                imu.file));
  }
  check_range(imu, source.sensor.gyro.range);
  return imu;
}

}  // namespace piste
