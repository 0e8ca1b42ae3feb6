#pragma once
/// Reads the logs of sensors, in several formats. Every error is a DataError `FILE:LINE: …`; no row is silently left
/// out.
///
/// Formats:
///  - csv: columns named with their units, in any order. IMU: `time_s`, then `gyro_{x,y,z}_{rad_s|deg_s}` and
///    `accel_{x,y,z}_{m_s2|g}`, or increments `dtheta_{x,y,z}_{rad|deg}` and `dvel_{x,y,z}_m_s`; optional
///    `temperature_degC`, `mag_{x,y,z}_uT`. GNSS: `time_s, latitude_deg, longitude_deg, height_m,
///    sigma_{north,east,down}_m`, optional `velocity_{north,east,down}_m_s` with
///    `sigma_velocity_{north,east,down}_m_s`. Attitude: `time_s, roll_deg, pitch_deg, heading_deg,
///    sigma_{roll,pitch,heading}_deg`.
///  - kf_gins: IMU `t dtheta x y z [rad] dvel x y z [m/s]`, increments since the row before; GNSS `t latitude longitude
///    [deg] height sigma n e d [m]`, optional `v n e d, their sigmas [m/s]`, and a quality flag that is not used.
///  - rtklib_pos: solution of RTKLIB in latitude, longitude, height, with its header line. Calendar or week times in
///    GPST or UTC or JST, degrees or degrees-minutes-seconds, optional velocities (a row whose velocity sigmas are all
///    0 has none).
///  - nmea: sentences of a receiver, in any order within an epoch: GGA for position, GST for its sigmas, RMC or ZDA for
///    the date, of any talker. Speed and course of RMC are a horizontal velocity where its sigma is stated. VTG, which
///    has no time, is checked; others are skipped if their checksum is right.
///  - ubx: frames of a u-blox receiver: NAV-PVT; other frames, and sentences between them, are skipped.
///  - xsens_ascii: text of Xsens, whose header gives the rate: a 16-bit Counter or PacketCounter, Acc_X … [m/s²],
///    Gyr_X … [rad/s], optional Mag_X … (its own unit) and Temperature, tab-separated. Time is the counter over the
///    rate, from 0 at the first row.
///  - imr: generic binary IMU format of Inertial Explorer; rates or increments.
///  - columns: text whose columns have names of their own; columns.h says where its values stand. IMU, GNSS, attitude.
///  - novatel: ASCII logs of NovAtel. GNSS: positions with their sigmas, such as BESTPOSA, and velocities at the same
///    times, such as BESTVELA, which have no sigma and are used where one is stated; the logs of one solution, that of
///    GNSS alone first. IMU: RAWIMUXA and RAWIMUSXA, increments, which name the type of the IMU. Others are skipped.
///  - inspva: attitude of NovAtel SPAN, as ASCII: INSPVAA, INSPVASA, and INSPVAXA or INSPVAXSA with their sigmas; other
///    logs, and sentences of NMEA, are skipped.
///
/// Times become seconds of the GPS week that the file begins in, and continue past 604800.

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/log.h"
#include "piste/io/columns.h"
#include "piste/io/number_columns.h"
#include "piste/io/row_fault.h"

namespace piste {

enum class LogFormat { kCsv, kKfGins, kRtklibPos, kNmea, kUbx, kXsensAscii, kImr, kNovatel, kInspva, kColumns };

/// Its name in configurations, such as `rtklib_pos`.
std::string_view name_of(LogFormat format);

/// A log, and how to read it.
struct LogFile {
  std::string file;
  LogFormat format = LogFormat::kCsv;
  std::vector<std::string> ignore_columns = {};  ///< of csv and xsens_ascii
  /// The bytes, if they are in memory already. `file` is then only their name in errors.
  std::optional<std::string_view> content = std::nullopt;
  /// The rows as numbers in memory instead, for csv. Errors then name the row, from 0.
  std::optional<NumberColumns> table = std::nullopt;
  /// Sigmas that the user states: north, east, down [m] of a receiver; roll, pitch, heading [rad] of an attitude. They
  /// replace those of the log.
  std::optional<Vector3d> sigma = std::nullopt;
  /// The same of velocities: north, east, down [m/s]. Without it speed and course of nmea are not used.
  std::optional<Vector3d> sigma_velocity = std::nullopt;
  /// Of a receiver: factors by which read_gnss() multiplies the sigmas, those of the log or those that the user states.
  SigmaScales sigma_scales = {};
  /// Whether rows are put in the order of time, and those of a repeated time dropped and counted. Else they are
  /// refused.
  bool repair = false;
  /// Whether rows share their stamps, as of a clock that counts whole seconds: they are spread up to the next stamp
  /// (spread_stamps).
  bool shared_stamps = false;
  /// The order that a reader is to ask of times.
  TimeOrder order() const {
    const bool any = repair || !clock_steps.empty() || as_it_stands;
    return any ? TimeOrder::kAny : shared_stamps ? TimeOrder::kShared : TimeOrder::kIncreasing;
  }
  /// Of an IMU: the steps of its clock, in the order of time. They are taken out of the times behind them.
  std::vector<ClockStep> clock_steps = {};
  /// Of an IMU: whether rows stay in the order of the file, whatever their times: to look for such steps.
  bool as_it_stands = false;
  /// Of a receiver: the qualities of fixes that are used. Empty: all but dead-reckoned ones.
  std::vector<FixQuality> use_quality = {};
  bool uses(FixQuality quality) const {
    if (use_quality.empty()) return quality != FixQuality::kDeadReckoned;
    return std::find(use_quality.begin(), use_quality.end(), quality) != use_quality.end();
  }
  /// Of an IMU: whether its rows are laid on the even clock of its samples (even_stamps).
  bool even_stamps = true;
  /// For columns: where the values stand.
  std::optional<ColumnMap> columns = std::nullopt;
  /// For columns: the file of the accelerometers, if they are logged apart from the gyroscopes.
  std::string accel_file = {};
  /// For columns: the file of gravity, whose rows are added to those of accelerations without it in `accel_file`.
  std::string gravity_file = {};
  /// For two such files: whether rows are instants (`sampling: instant`), or means over the interval before them.
  bool instant = false;
};

// With `faults` a refused row is left out and listed there, units are not judged, and sigmas that nobody states are
// infinite: this is for inspection, not for use. A file that cannot be read at all still throws.

/// Reads an IMU's rows, in sensor axes and sensor time. Formats: csv, kf_gins, xsens_ascii, imr, novatel, columns.
/// Numbers that look like another unit than the stated one are an error.
ImuRecording read_imu(const LogFile& log, RowFaults* faults = nullptr);

/// Reads the fixes of a receiver. Formats: csv, kf_gins, rtklib_pos, nmea, ubx, novatel, columns.
GnssRecording read_gnss(const LogFile& log, RowFaults* faults = nullptr);

/// Reads the attitudes of a reference. Formats: csv, inspva, columns.
AttitudeRecording read_attitude(const LogFile& log, RowFaults* faults = nullptr);

/// Read a csv of one number per row. An odometer has its speed, `time_s, speed_m_s`, with an optional
/// `sigma_speed_m_s`. A barometer has its height, `height_m` or `pressure_hPa`, with `sigma_height_m` or
/// `sigma_pressure_hPa`. Two antennas have their heading, `heading_deg` and `sigma_heading_deg`, with optional
/// `pitch_deg` and `sigma_pitch_deg`. A pressure becomes the height of the standard atmosphere (ICAO Doc 7488). The
/// sigma may also be called `sigma`, in the unit of the value. `sigma` holds where the log has none; LogFile::sigma
/// replaces those of the log. A speed below zero, beyond noise, is an error unless the wheel `is_signed`.
FixRecording<SpeedFix> read_speed(const LogFile& log, double sigma, bool is_signed = true);
FixRecording<HeightFix> read_height(const LogFile& log, double sigma);
FixRecording<HeadingFix> read_heading(const LogFile& log, double sigma);

}  // namespace piste
