// Logs of one number a row: odometer, barometer, heading of two antennas.

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "io/csv.h"
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

// Of the pitch of a baseline against its heading, where no sigma is told: satellites are all above.
constexpr double kUpright = 2;

struct NoMore {
  void operator()(auto&) const {}
};

// The rows of a file: `value` and `sigma` turn what stands in the two columns into the numbers of the fix; the second
// is given the value as well. `more(fix)` reads what else stands in the row.
template <class Fix, class Value, class Sigma, class More = NoMore>
FixRecording<Fix> read_rows(CsvReader& csv, const LogFile& log, std::string_view column, std::string_view sigma_column,
                            const Value& value, const Sigma& sigma, double fallback, const More& more = {}) {
  const auto time = csv.column("time_s"), number = csv.column(column);
  auto spread = csv.find(sigma_column);
  if (!spread) spread = csv.find("sigma");  // in the unit of the value
  csv.finish_header();
  FixRecording<Fix> recording{log.file, {}};
  IncreasingTime increasing(log.repair);
  while (csv.next()) {
    const double t = increasing.next(csv[time], csv.text());
    const double told = spread ? sigma(csv[*spread], csv[number]) : fallback;
    Fix fix{t, value(csv[number]), log.sigma ? log.sigma->x() : told};
    more(fix);
    if (!(fix.sigma > 0)) csv.fail(fmt::format("{} must be above zero", sigma_column));
    recording.fixes.push_back(fix);
  }
  if (recording.fixes.empty()) throw DataError(log.file + ":1", fmt::format("holds no row of {}", column));
  return recording;
}

}  // namespace

FixRecording<SpeedFix> read_speed(const LogFile& log, double sigma) {
  CsvReader csv(log);
  const auto same = [](double x, double = 0) { return x; };
  return read_rows<SpeedFix>(csv, log, "speed_m_s", "sigma_speed_m_s", same, same, sigma);
}

FixRecording<HeightFix> read_height(const LogFile& log, double sigma) {
  CsvReader csv(log);
  const auto same = [](double x, double = 0) { return x; };
  if (csv.find("height_m")) return read_rows<HeightFix>(csv, log, "height_m", "sigma_height_m", same, same, sigma);
  if (!csv.find("pressure_hPa")) csv.fail("no height: a column height_m or pressure_hPa is expected");
  const auto height = [&](double pressure) {
    if (!(pressure > 200 && pressure < 1200)) {
      csv.fail(fmt::format("a pressure of {} hPa is none of the air; is the column in Pa?", pressure));
    }
    return standard_height(pressure);
  };
  const auto spread = [](double s, double pressure) { return s * height_by_pressure(pressure); };
  return read_rows<HeightFix>(csv, log, "pressure_hPa", "sigma_pressure_hPa", height, spread, sigma);
}

FixRecording<HeadingFix> read_heading(const LogFile& log, double sigma) {
  CsvReader csv(log);
  const auto pitch = csv.find("pitch_deg"), sigma_pitch = csv.find("sigma_pitch_deg");
  const auto radians = [](double x, double = 0) { return kDegree * x; };
  return read_rows<HeadingFix>(csv, log, "heading_deg", "sigma_heading_deg", radians, radians, sigma,
                               [&](HeadingFix& fix) {
                                 if (!pitch) return;
                                 fix.pitch = kDegree * csv[*pitch];
                                 fix.sigma_pitch = sigma_pitch ? kDegree * csv[*sigma_pitch] : kUpright * fix.sigma;
                                 if (!(fix.sigma_pitch > 0)) csv.fail("sigma_pitch_deg must be above zero");
                               });
}

}  // namespace piste
