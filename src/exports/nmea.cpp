/// NMEA 0183: GGA and RMC of each row.

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "exports/formats.h"
#include "math/geoid.h"

namespace piste::export_formats {
namespace {

// Degrees and minutes with 7 decimals, and the letter; rounded once, so that 60 minutes do not stand there.
std::string angle_text(double degrees, int digits, char positive, char negative) {
  constexpr std::int64_t kMinute = 10'000'000, kDegreeParts = 60 * kMinute;
  const std::int64_t parts = std::llround(std::abs(degrees) * static_cast<double>(kDegreeParts)),
                     rest = parts % kDegreeParts;
  return fmt::format("{:0{}}{:02}.{:07},{}", parts / kDegreeParts, digits, rest / kMinute, rest % kMinute,
                     degrees < 0 ? negative : positive);
}

std::string sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return fmt::format("${}*{:02X}\r\n", body, sum);
}

}  // namespace

std::vector<ExportedFile> nmea(const ExportRun& run) {
  constexpr double kKnot = 1852.0 / 3600;
  constexpr std::int64_t kCircle = 3'600'000;  // course in 1e-4 deg
  std::string text;
  for (std::size_t i = 0; i < run.track.size(); ++i) {
    const Geodetic& place = run.track.place[i];
    const Vector3d& v = run.track.velocity[i];
    const CalendarTime t = calendar_time(gps_time_of(run, i), TimeSystem::kUtc);
    const std::string time = fmt::format("{:02}{:02}{:02}.{:06}", t.hour, t.minute, t.second, t.microsecond),
                      where = angle_text(kDegreesPerRadian * place.latitude, 2, 'N', 'S') + "," +
                              angle_text(kDegreesPerRadian * place.longitude, 3, 'E', 'W');
    const double undulation = geoid_undulation(place);
    text += sentence(
        fmt::format("GPGGA,{},{},1,,,{:.4f},M,{:.4f},M,,", time, where, place.height - undulation, undulation));
    const std::int64_t course = (std::llround(kDegreesPerRadian * std::atan2(v.y(), v.x()) * 1e4) + kCircle) % kCircle;
    text += sentence(fmt::format("GPRMC,{},A,{},{:.4f},{}.{:04},{:02}{:02}{:02},,,A", time, where,
                                 std::hypot(v.x(), v.y()) / kKnot, course / 10000, course % 10000, t.day, t.month,
                                 t.year % 100));
  }
  return {{".nmea", std::move(text)}};
}

}  // namespace piste::export_formats
