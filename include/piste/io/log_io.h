#pragma once
/// Recorded logs, as read: one reader a format. Every error is a DataError `FILE:LINE: …`; nothing is left out.
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
///  - rtklib_pos: solution of RTKLIB in latitude, longitude, height, with its header. Calendar or week times in GPST or
///    UTC, degrees or degrees-minutes-seconds, optional velocities (a row whose velocity sigmas are all 0 has none).
///
/// Times become seconds of the GPS week that the file begins in, and continue past 604800.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/log.h"
#include "piste/io/row_fault.h"

namespace piste {

enum class LogFormat { kCsv, kKfGins, kRtklibPos };

struct LogFile {
  std::string file;
  LogFormat format = LogFormat::kCsv;
  std::vector<std::string> ignore_columns = {};  ///< of csv
  /// The bytes, where they are in memory already; `file` then only names them.
  std::optional<std::string_view> content = std::nullopt;
};

// With `faults` a refused row is left out and listed there, and units are not judged: for those who look a log over,
// not for those who use it. A file that cannot be read at all throws all the same.

/// IMU rows in sensor axes and sensor time. Refuses numbers that look like another unit than their label's.
/// csv, kf_gins.
ImuRecording read_imu(const LogFile& log, RowFaults* faults = nullptr);

/// Fixes of one receiver. csv, kf_gins, rtklib_pos.
GnssRecording read_gnss(const LogFile& log, RowFaults* faults = nullptr);

/// Attitudes of one reference. csv.
AttitudeRecording read_attitude(const LogFile& log, RowFaults* faults = nullptr);

}  // namespace piste
