#include <fmt/format.h>

#include "log_formats.h"

namespace piste::log_formats {
namespace {

Vector3d three(const TextReader& reader, std::size_t first) {
  return {reader.number(first), reader.number(first + 1), reader.number(first + 2)};
}

}  // namespace

ImuRecording read_imu_kf_gins(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kSpaces, log.content);
  ImuRecording imu;
  imu.file = log.file;
  imu.increments = true;
  IncreasingTime increasing(log.order());
  const auto row = [&] {
    if (reader.fields().size() != 7) {
      reader.fail(
          fmt::format("{} fields; 7 are expected: t, dtheta x y z [rad], dvel x y z [m/s]", reader.fields().size()),
          RowFault::Kind::kFields);
    }
    const double t = increasing.next(reader.number(0), reader);
    const Vector3d dtheta = three(reader, 1);
    const Vector3d dvel = three(reader, 4);
    if (is_for_use(faults)) check_turn(dtheta, t, imu, reader);
    imu.time.push_back(t);
    imu.gyro.push_back(dtheta);
    imu.accel.push_back(dvel);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return imu;
}

GnssRecording read_gnss_kf_gins(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kSpaces, log.content);
  GnssRecording gnss{log.file, {}};
  IncreasingTime increasing(log.order());
  std::size_t columns = 0;
  const auto row = [&] {
    const std::size_t found = reader.fields().size();
    if (columns == 0) columns = found;
    if (found != columns || (found != 7 && found != 13 && found != 14)) {
      reader.fail(
          fmt::format("{} fields; 7 are expected: t, latitude, longitude [deg], height, sigma n e d [m]; then 6 of "
                      "velocity n e d and sigmas [m/s] or none, and a quality flag or none; all rows alike",
                      found),
          RowFault::Kind::kFields);
    }
    if (!has_coordinates(reader.number(1), reader.number(2))) {
      ++gnss.without_fix;
      return;
    }
    GeodeticFix fix;
    fix.time = increasing.next(reader.number(0), reader);
    fix.position = geodetic_degrees(reader.number(1), reader.number(2), reader.number(3));
    fix.sigma_position = three(reader, 4);
    if (found > 7) fix.velocity = {three(reader, 7), three(reader, 10)};
    check_fix(fix, log, reader);
    gnss.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return gnss;
}

}  // namespace piste::log_formats
