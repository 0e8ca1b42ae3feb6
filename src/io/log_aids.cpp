// Logs of one number a row: odometer, barometer, heading of two antennas.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/recording.h"
#include "io/csv.h"
#include "io/left_out_rows.h"
#include "io/log_formats.h"
#include "piste/core/error.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// Height by pressure in the standard atmosphere's lowest layer: T/L (1 − (p/p₀)^(R L / g)).
constexpr double kStandardPressure = 1013.25, kLayer = 44330.77, kPower = 0.190263;

double standard_height(double pressure) { return kLayer * (1 - std::pow(pressure / kStandardPressure, kPower)); }
// m by which the height falls for one hPa more
double height_by_pressure(double pressure) {
  return kLayer * kPower / kStandardPressure * std::pow(pressure / kStandardPressure, kPower - 1);
}

// Sigma of the pitch of a baseline over that of its heading, where none is stated: satellites are all above.
constexpr double kSteeper = 2;

struct NoMore {
  void operator()(auto&) const {}
};

void require_positive(double sigma, std::string_view column, std::string_view example, const CsvReader& csv) {
  if (sigma > 0) return;
  csv.fail(fmt::format("{} must be above zero; `sigma: {}` in the configuration replaces it", column, example));
}

/// The columns of a sensor's values and of its sigma.
struct AidColumns {
  std::string_view value, sigma, example;
};

// The rows of a file: `value` and `sigma` convert the two columns to the numbers of the fix; `sigma` takes the value as
// well. `more(fix)` reads the other columns of the row. Sigmas that the configuration replaces may be anything finite.
template <class Fix, class Value, class Sigma, class More = NoMore>
FixRecording<Fix> read_rows(CsvReader& csv, const LogFile& log, const AidColumns& columns, const Value& value,
                            const Sigma& sigma, double fallback, const More& more = {}) {
  const auto time = csv.column("time_s"), number = csv.column(columns.value);
  std::string_view spread_name = columns.sigma;
  auto spread = csv.find(spread_name);
  if (!spread) spread = csv.find(spread_name = "sigma");  // in the unit of the value
  csv.finish_header();
  FixRecording<Fix> recording{log.file, {}};
  IncreasingTime increasing(log.order());
  LeftOutRows left_out(log, nullptr);
  const auto row = [&] {
    Fix fix{increasing.next(csv[time], csv.text()), value(csv[number]), fallback};
    if (log.sigma) {
      fix.sigma = log.sigma->x();
    } else if (spread) {
      fix.sigma = sigma(csv[*spread], csv[number]);
    }
    require_positive(fix.sigma, spread_name, columns.example, csv);
    more(fix);
    recording.fixes.push_back(fix);
  };
  for_each_row(
      left_out.list(), [&] { return csv.next(); }, row);
  left_out.count_in(recording.repaired, recording.fixes.size());
  if (log.repair) repair_rows(recording);
  if (recording.fixes.empty()) throw DataError(log.file + ":1", fmt::format("holds no row of {}", columns.value));
  return recording;
}

// Of a receiver with two antennas.
FixRecording<HeadingFix> read_receiver_heading(const LogFile& log, double sigma) {
  FixRecording<HeadingFix> recording = log.format == LogFormat::kUbx ? log_formats::read_heading_ubx(log, sigma)
                                       : log.format == LogFormat::kNovatel
                                           ? log_formats::read_heading_novatel(log, sigma)
                                           : log_formats::read_heading_nmea(log, sigma);
  if (recording.fixes.empty()) {
    throw DataError(log.file + ":1",
                    "holds no heading; NAV-RELPOSNED (ubx), HEADING2A (novatel), HDT or THS (nmea) are "
                    "read");
  }
  for (HeadingFix& fix : recording.fixes) {
    if (log.sigma) fix.sigma = log.sigma->x();
    if (!(fix.sigma > 0)) {
      throw DataError(log.file, "a heading has no sigma above zero; `sigma: 0.5 deg` in the configuration states it");
    }
    if (fix.pitch && !(fix.sigma_pitch > 0 && !log.sigma)) fix.sigma_pitch = kSteeper * fix.sigma;
  }
  return recording;
}

}  // namespace

FixRecording<SpeedFix> read_speed(const LogFile& log, double sigma, bool is_signed) {
  constexpr double kNoise = 5, kReverse = 1;  // sigmas, m/s: by noise a standing wheel goes no further below zero
  CsvReader csv(log);
  const auto same = [](double x, double = 0) { return x; };
  return read_rows<SpeedFix>(
      csv, log, {"speed_m_s", "sigma_speed_m_s", "0.1 m/s"}, same, same, sigma, [&](const SpeedFix& fix) {
        if (is_signed || fix.speed >= -std::max(kReverse, kNoise * fix.sigma)) return;
        csv.fail(
            fmt::format("a speed of {} m/s; of a wheel that is negative backwards, say `signed: true`", fix.speed));
      });
}

FixRecording<HeightFix> read_height(const LogFile& log, double sigma) {
  CsvReader csv(log);
  const auto same = [](double x, double = 0) { return x; };
  constexpr std::string_view kExample = "0.5 m";
  if (csv.find("height_m")) {
    return read_rows<HeightFix>(csv, log, {"height_m", "sigma_height_m", kExample}, same, same, sigma);
  }
  if (!csv.find("pressure_hPa")) csv.fail("no height: a column height_m or pressure_hPa is expected");
  const auto height = [&](double pressure) {
    if (!(pressure > 200 && pressure < 1200)) {
      csv.fail(fmt::format("a pressure of {} hPa is none of the air; is the column in Pa? Divide it by 100", pressure));
    }
    return standard_height(pressure);
  };
  const auto spread = [](double s, double pressure) { return s * height_by_pressure(pressure); };
  return read_rows<HeightFix>(csv, log, {"pressure_hPa", "sigma_pressure_hPa", kExample}, height, spread, sigma);
}

FixRecording<HeadingFix> read_heading(const LogFile& log, double sigma) {
  if (log.format != LogFormat::kCsv) return read_receiver_heading(log, sigma);
  constexpr double kTurn = 360, kUpright = 90;  // deg
  constexpr std::string_view kExample = "0.5 deg";
  CsvReader csv(log);
  const auto pitch = csv.find("pitch_deg"), sigma_pitch = csv.find("sigma_pitch_deg");
  const auto radians = [](double x, double = 0) { return kDegree * x; };
  const auto azimuth = [&](double heading) {
    if (std::abs(heading) > kTurn) {
      csv.fail(fmt::format("a heading of {} deg is out of range; within 360 deg is expected", heading));
    }
    return kDegree * heading;
  };
  return read_rows<HeadingFix>(
      csv, log, {"heading_deg", "sigma_heading_deg", kExample}, azimuth, radians, sigma, [&](HeadingFix& fix) {
        if (!pitch) return;
        if (std::abs(csv[*pitch]) > kUpright) {
          csv.fail(fmt::format("a pitch of {} deg is out of range; within 90 deg is expected", csv[*pitch]));
        }
        fix.pitch = kDegree * csv[*pitch];
        fix.sigma_pitch = sigma_pitch && !log.sigma ? kDegree * csv[*sigma_pitch] : kSteeper * fix.sigma;
        require_positive(fix.sigma_pitch, "sigma_pitch_deg", kExample, csv);
      });
}

}  // namespace piste
