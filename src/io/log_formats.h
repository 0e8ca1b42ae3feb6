#pragma once
/// The readers behind log_io.h, one file a format, and what they share.

#include "io/text_reader.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"

namespace piste::log_formats {

ImuRecording read_imu_csv(const LogFile& log, RowFaults* faults);
GnssRecording read_gnss_csv(const LogFile& log, RowFaults* faults);
AttitudeRecording read_attitude_csv(const LogFile& log, RowFaults* faults);
ImuRecording read_imu_kf_gins(const LogFile& log, RowFaults* faults);
GnssRecording read_gnss_kf_gins(const LogFile& log, RowFaults* faults);
GnssRecording read_gnss_rtklib(const LogFile& log, RowFaults* faults);
GnssRecording read_gnss_nmea(const LogFile& log, RowFaults* faults);
GnssRecording read_gnss_ubx(const LogFile& log, RowFaults* faults);
ImuRecording read_imu_xsens(const LogFile& log, RowFaults* faults);
ImuRecording read_imu_imr(const LogFile& log, RowFaults* faults);
AttitudeRecording read_attitude_inspva(const LogFile& log, RowFaults* faults);

/// What stands between `$` and `*` of a sentence of NMEA 0183; none where that is not one with a right checksum.
std::optional<std::string_view> nmea_body(std::string_view line);

/// Refuses an angular rate [rad/s] that no sensor measures: degrees where radians are declared.
void check_rate(const Vector3d& rate, const RowSource& row);

/// Refuses places outside the Earth's ranges and sigmas that are not above zero.
void check_fix(const GeodeticFix& fix, const RowSource& row);

/// Refuses angles outside their ranges and sigmas that are not above zero.
void check_attitude(const EulerFix& fix, const RowSource& row);

/// Latitude and longitude in degrees, height in metres.
inline Geodetic geodetic_degrees(double latitude, double longitude, double height) {
  return {latitude * kDegree, longitude * kDegree, height};
}

}  // namespace piste::log_formats
