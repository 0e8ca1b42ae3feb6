#pragma once
/// The readers behind log_io.h, one source file for each format, and the checks that they share.

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

/// The text between `$` and `*` of a sentence of NMEA 0183, or nothing if the line is not a sentence with a right
/// checksum.
std::optional<std::string_view> nmea_body(std::string_view line);

/// Throws if an angular rate [rad/s] is larger than any sensor measures: then degrees were declared as radians.
void check_rate(const Vector3d& rate, const RowSource& row);

/// Throws if latitude, longitude or height are impossible, or a sigma is not above zero.
void check_fix(const GeodeticFix& fix, const RowSource& row);

/// Throws if an angle is outside its range, or a sigma is not above zero.
void check_attitude(const EulerFix& fix, const RowSource& row);

/// A place from latitude and longitude in degrees and height in metres.
inline Geodetic geodetic_degrees(double latitude, double longitude, double height) {
  return {latitude * kDegree, longitude * kDegree, height};
}

}  // namespace piste::log_formats
