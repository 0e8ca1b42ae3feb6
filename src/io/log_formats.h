#pragma once
/// The readers behind log_io.h, one source file for each format, and the checks that they share.

#include <limits>

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
ImuRecording read_imu_novatel(const LogFile& log, RowFaults* faults);
GnssRecording read_gnss_novatel(const LogFile& log, RowFaults* faults);
ImuRecording read_imu_columns(const LogFile& log, RowFaults* faults);
GnssRecording read_gnss_columns(const LogFile& log, RowFaults* faults);
AttitudeRecording read_attitude_columns(const LogFile& log, RowFaults* faults);
AttitudeRecording read_attitude_inspva(const LogFile& log, RowFaults* faults);

/// Headings of two antennas: NAV-RELPOSNED of ubx, HEADING2A and HEADINGA of novatel, HDT and THS of nmea. `sigma`:
/// where the log has none.
FixRecording<HeadingFix> read_heading_ubx(const LogFile& log, double sigma);
FixRecording<HeadingFix> read_heading_novatel(const LogFile& log, double sigma);
FixRecording<HeadingFix> read_heading_nmea(const LogFile& log, double sigma);

/// The text between `$` and `*` of a sentence of NMEA 0183, or nothing if the line is not a sentence with a right
/// checksum.
std::optional<std::string_view> nmea_body(std::string_view line);

/// Throws if an angular rate [rad/s] is larger than any sensor measures: then degrees were declared as radians.
void check_rate(const Vector3d& rate, const RowSource& row);

/// The same for an increment [rad] that ends at `time`, behind the last row of `imu`.
void check_turn(const Vector3d& dtheta, double time, const ImuRecording& imu, const RowSource& row);

/// Takes the steps of its clock out of an IMU's times. Throws DataError if the rows are not in order then, unless they
/// are to be put in order.
void take_out_steps(ImuRecording& imu, const LogFile& log);

/// The sigma where none is stated.
inline Vector3d unknown_sigma() { return Vector3d::Constant(std::numeric_limits<double>::infinity()); }

/// Whether a row of a receiver's table has a position. Latitude and longitude of exactly 0 are a logger's sign for no
/// fix. Such a row is counted, and nothing else of it is read.
inline bool has_coordinates(double latitude, double longitude) { return latitude != 0 || longitude != 0; }

/// Gives a fix the sigmas that its configuration states, if it does. Throws if latitude, longitude or height are then
/// impossible, or a sigma is not above zero.
void check_fix(GeodeticFix& fix, const LogFile& log, const RowSource& row);

/// The same for an attitude, whose angles must be within their ranges.
void check_attitude(EulerFix& fix, const LogFile& log, const RowSource& row);

/// A place from latitude and longitude in degrees and height in metres.
inline Geodetic geodetic_degrees(double latitude, double longitude, double height) {
  return {latitude * kDegree, longitude * kDegree, height};
}

}  // namespace piste::log_formats
