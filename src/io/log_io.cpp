#include "piste/io/log_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/fix_faults.h"
#include "core/recording.h"
#include "io/left_out_rows.h"
#include "log_formats.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

[[noreturn]] void wrong_format(const LogFile& log, std::string_view kind, std::string_view formats) {
  throw ConfigError(log.file, fmt::format("{} is read from {}", kind, formats));
}

// What a log of this format must have, in words for an error.
std::string_view needed(LogFormat format) {
  switch (format) {
    case LogFormat::kNmea:
      return "; sentences GGA, GST and RMC of a receiver that has one are read";
    case LogFormat::kUbx:
      return "; frames NAV-PVT of a receiver that has one are read";
    case LogFormat::kNovatel:
      return "; logs BESTGNSSPOSA, BESTPOSA, RTKPOSA, PPPPOSA or PSRPOSA that are computed are read";
    case LogFormat::kInspva:
      return "; logs INSPVAA, INSPVASA or INSPVAXA that are aligned are read";
    case LogFormat::kCsv:
    case LogFormat::kKfGins:
    case LogFormat::kRtklibPos:
    case LogFormat::kXsensAscii:
    case LogFormat::kImr:
    case LogFormat::kColumns:
      break;
  }
  return {};
}

template <class Fixes>
void require_rows(const Fixes& fixes, const LogFile& log, std::string_view what) {
  if (fixes.empty()) throw DataError(log.file + ":1", fmt::format("holds no {}{}", what, needed(log.format)));
}

// Checks the unit of the specific force: its median must be near gravity. Single glitches do not change the median.
void check_gravity(const ImuRecording& imu) {
  std::vector<double> forces;
  forces.reserve(imu.time.size());
  for (std::size_t i = 1; i < imu.time.size(); ++i) {
    forces.push_back(imu.accel[i].norm() / (imu.increments ? imu.time[i] - imu.time[i - 1] : 1));
  }
  if (forces.empty()) throw DataError(imu.file + ":1", "holds fewer than two IMU rows");
  const double typical = median(std::move(forces));
  if (typical >= 3 && typical <= 30) return;
  throw DataError(
      imu.file + ":1",
      fmt::format("the median specific force is {:.4g} m/s^2 and should be near 9.8; {}", typical,
                  imu.increments
                      ? "dvel must be velocity increments in m/s since the row before"
                      : "are the columns in g (accel_x_g) or in m/s^2 (accel_x_m_s2), or increments (dvel_x_m_s)? With "
                        "`columns:`, what is their unit? Or is gravity taken out of them, as of a phone's linear "
                        "acceleration? Then log the accelerometers' own output"));
}

// Leaves out fixes that are no measurements, or of a quality that the user does not want.
void leave_out_qualities(GnssRecording& gnss, const LogFile& log) {
  gnss.not_used += std::erase_if(gnss.fixes, [&](const GeodeticFix& fix) { return !log.uses(fix.quality); });
}

}  // namespace

std::string_view name_of(LogFormat format) {
  switch (format) {
    case LogFormat::kCsv:
      return "csv";
    case LogFormat::kKfGins:
      return "kf_gins";
    case LogFormat::kRtklibPos:
      return "rtklib_pos";
    case LogFormat::kNmea:
      return "nmea";
    case LogFormat::kUbx:
      return "ubx";
    case LogFormat::kXsensAscii:
      return "xsens_ascii";
    case LogFormat::kImr:
      return "imr";
    case LogFormat::kNovatel:
      return "novatel";
    case LogFormat::kInspva:
      return "inspva";
    case LogFormat::kColumns:
      return "columns";
  }
  return "";
}

ImuRecording read_imu(const LogFile& log, RowFaults* faults) {
  LeftOutRows left_out(log, faults);
  ImuRecording imu;
  switch (log.format) {
    case LogFormat::kCsv:
      imu = log_formats::read_imu_csv(log, left_out.list());
      break;
    case LogFormat::kKfGins:
      imu = log_formats::read_imu_kf_gins(log, left_out.list());
      break;
    case LogFormat::kXsensAscii:
      imu = log_formats::read_imu_xsens(log, left_out.list());
      break;
    case LogFormat::kImr:
      imu = log_formats::read_imu_imr(log, left_out.list());
      break;
    case LogFormat::kNovatel:
      imu = log_formats::read_imu_novatel(log, left_out.list());
      break;
    case LogFormat::kColumns:
      imu = log_formats::read_imu_columns(log, left_out.list());
      break;
    case LogFormat::kRtklibPos:
    case LogFormat::kNmea:
    case LogFormat::kUbx:
    case LogFormat::kInspva:
      wrong_format(log, "an IMU", "csv, kf_gins, xsens_ascii, imr, novatel or columns");
  }
  left_out.count_in(imu.repaired, imu.time.size());
  if (log.accel_file.empty()) log_formats::take_out_steps(imu, log);
  if (log.as_it_stands) return imu;
  if (log.shared_stamps && log.accel_file.empty()) spread_stamps(imu);
  if (log.repair) repair_rows(imu);
  if (log.even_stamps && log.accel_file.empty()) even_stamps(imu);
  if (faults == nullptr) check_gravity(imu);
  return imu;
}

GnssRecording read_gnss(const LogFile& log, RowFaults* faults) {
  LeftOutRows left_out(log, faults);
  GnssRecording gnss;
  switch (log.format) {
    case LogFormat::kCsv:
      gnss = log_formats::read_gnss_csv(log, left_out.list());
      break;
    case LogFormat::kKfGins:
      gnss = log_formats::read_gnss_kf_gins(log, left_out.list());
      break;
    case LogFormat::kRtklibPos:
      gnss = log_formats::read_gnss_rtklib(log, left_out.list());
      break;
    case LogFormat::kNmea:
      gnss = log_formats::read_gnss_nmea(log, left_out.list());
      break;
    case LogFormat::kUbx:
      gnss = log_formats::read_gnss_ubx(log, left_out.list());
      break;
    case LogFormat::kNovatel:
      gnss = log_formats::read_gnss_novatel(log, left_out.list());
      break;
    case LogFormat::kColumns:
      gnss = log_formats::read_gnss_columns(log, left_out.list());
      break;
    case LogFormat::kXsensAscii:
    case LogFormat::kImr:
    case LogFormat::kInspva:
      wrong_format(log, "GNSS", "csv, kf_gins, rtklib_pos, nmea, ubx, novatel or columns");
  }
  leave_out_qualities(gnss, log);
  left_out.count_in(gnss.repaired, gnss.fixes.size() + gnss.not_used);
  if (log.shared_stamps) spread_stamps(gnss);
  if (log.repair) repair_rows(gnss);
  scale_sigmas(gnss.fixes, log.sigma_scales);
  if (faults == nullptr && gnss.not_used > 0 && gnss.fixes.empty()) {
    throw DataError(log.file + ":1", fmt::format("none of its {} fixes is of a quality that is used; `use_quality` "
                                                 "names those that are, and dead-reckoned ones are no measurements",
                                                 gnss.not_used));
  }
  if (faults == nullptr) require_rows(gnss.fixes, log, "fix");
  return gnss;
}

AttitudeRecording read_attitude(const LogFile& log, RowFaults* faults) {
  LeftOutRows left_out(log, faults);
  AttitudeRecording attitude;
  if (log.format == LogFormat::kCsv) {
    attitude = log_formats::read_attitude_csv(log, left_out.list());
  } else if (log.format == LogFormat::kInspva) {
    attitude = log_formats::read_attitude_inspva(log, left_out.list());
  } else if (log.format == LogFormat::kColumns) {
    attitude = log_formats::read_attitude_columns(log, left_out.list());
  } else {
    wrong_format(log, "an attitude", "csv, inspva or columns");
  }
  left_out.count_in(attitude.repaired, attitude.fixes.size());
  if (log.repair) repair_rows(attitude);
  if (faults == nullptr) require_rows(attitude.fixes, log, "attitude");
  return attitude;
}

namespace log_formats {

void take_out_steps(ImuRecording& imu, const LogFile& log) {
  piste::take_out_steps(imu, log.clock_steps);
  if (log.clock_steps.empty() || log.repair) return;
  const auto back = std::adjacent_find(imu.time.begin(), imu.time.end(), std::greater_equal<>());
  if (back == imu.time.end()) return;
  throw DataError(imu.file,
                  fmt::format("without the steps of its clock, time {:.6f} s does not increase after {:.6f} s; "
                              "name all steps, or let piste sort the rows: `repair: true`",
                              *(back + 1), *back));
}

void check_rate(const Vector3d& rate, const RowSource& row) {
  constexpr double kFastest = 60;
  const double largest = rate.cwiseAbs().maxCoeff();
  if (largest > kFastest) {
    row.fail(
        fmt::format("an angular rate of {:.4g} rad/s: these look like degrees; name the columns gyro_x_deg_s "
                    "(or dtheta_x_deg), with `columns:` give the unit deg/s, or convert them",
                    largest));
  }
}

void check_turn(const Vector3d& dtheta, double time, const ImuRecording& imu, const RowSource& row) {
  if (!imu.time.empty() && time > imu.time.back()) check_rate(dtheta / (time - imu.time.back()), row);
}

void check_fix(GeodeticFix& fix, const LogFile& log, const RowSource& row) {
  if (log.sigma) {
    fix.sigma_position = *log.sigma;
    fix.correlation.setZero();
  }
  if (fix.velocity && log.sigma_velocity) {
    const bool has_down = fix.velocity->has_down();
    fix.velocity->sigma.head<2>() = log.sigma_velocity->head<2>();
    if (has_down) fix.velocity->sigma.z() = log.sigma_velocity->z();
  }
  if (const std::string fault = fault_of(fix.position); !fault.empty()) row.fail(fault);
  if (!are_sigmas(fix.sigma_position)) {
    row.fail("the sigmas of a position must be above zero; `sigma: 2 2 4 m` in the configuration replaces them");
  }
  if (fix.velocity && !are_sigmas(fix.velocity->sigma)) {
    row.fail(
        "the sigmas of a velocity must be above zero; `sigma_velocity: 0.1 m/s` in the configuration replaces them");
  }
}

void check_attitude(EulerFix& fix, const LogFile& log, const RowSource& row) {
  if (log.sigma) fix.sigma = *log.sigma;
  const Vector3d largest = Vector3d(180, 90, 360) * (kDegree * (1 + 1e-9));
  if ((fix.angles.cwiseAbs().array() > largest.array()).any()) {
    row.fail("an angle is out of range; roll within 180, pitch within 90, heading within 360 deg are expected");
  }
  if (!(fix.sigma.minCoeff() > 0)) row.fail("the sigmas of an attitude must be above zero");
}

}  // namespace log_formats
}  // namespace piste
