#pragma once
/// What every reader promises, whatever the bytes: recordings that hold what they say, or a DataError.

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "piste/core/error.h"
#include "piste/io/log_io.h"

namespace piste::fuzz {

/// Ends the program where a promise is broken: a crash, which the fuzzer keeps and whose place it tells.
inline void require(bool kept) {
  if (!kept) std::abort();
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

inline void check(const std::vector<Vector3d>& values, std::size_t rows) {
  require(values.size() == rows);
  for (const Vector3d& value : values) require(value.allFinite());
}

/// Each later than the one before: `time_of(i)` of `rows` rows.
template <class TimeOf>
void check_times(std::size_t rows, TimeOf&& time_of) {
  for (std::size_t i = 0; i < rows; ++i) {
    require(std::isfinite(time_of(i)));
    require(i == 0 || time_of(i) > time_of(i - 1));
  }
}

inline void check(const ImuRecording& imu, const RowFaults* /*faults*/) {
  const std::size_t rows = imu.time.size();
  check_times(rows, [&](std::size_t i) { return imu.time[i]; });
  check(imu.gyro, rows);
  check(imu.accel, rows);
  if (!imu.magnetic.empty()) check(imu.magnetic, rows);
  require(imu.temperature.empty() || imu.temperature.size() == rows);
  for (const double t : imu.temperature) require(std::isfinite(t));
}

/// Sigmas are above zero, and infinite where nobody states them and `faults` are listed.
inline void check_sigma(const Vector3d& sigma, const RowFaults* faults) {
  require(sigma.minCoeff() > 0);
  require(sigma.allFinite() || faults != nullptr);
}

inline void check(const GnssRecording& gnss, const RowFaults* faults) {
  check_times(gnss.fixes.size(), [&](std::size_t i) { return gnss.fixes[i].time; });
  for (const GeodeticFix& fix : gnss.fixes) {
    require(std::abs(fix.position.latitude) <= 1.5707963267948968);
    require(std::abs(fix.position.longitude) <= 6.2831853071795865);
    require(std::abs(fix.position.height) <= 1e6);
    check_sigma(fix.sigma_position, faults);
    if (!fix.velocity) continue;
    require(fix.velocity->value.allFinite());
    check_sigma({fix.velocity->sigma.x(), fix.velocity->sigma.y(), 1}, faults);
    require(fix.velocity->sigma.z() > 0);  // infinite if down was not measured
  }
}

inline void check(const AttitudeRecording& attitude, const RowFaults* faults) {
  check_times(attitude.fixes.size(), [&](std::size_t i) { return attitude.fixes[i].time; });
  for (const EulerFix& fix : attitude.fixes) {
    require(fix.angles.allFinite());
    check_sigma(fix.sigma, faults);
  }
}

inline std::size_t rows(const ImuRecording& imu) { return imu.time.size(); }
inline std::size_t rows(const GnssRecording& gnss) { return gnss.fixes.size(); }
inline std::size_t rows(const AttitudeRecording& attitude) { return attitude.fixes.size(); }

/// Reads with `read(LogFile, RowFaults*)`, strictly and listing faults: what the strict reading takes is whole.
template <class Read>
void both_ways(const LogFile& log, Read&& read) {
  std::optional<std::size_t> taken;
  try {
    const auto recording = read(log, nullptr);
    check(recording, nullptr);
    taken = rows(recording);
  } catch (const DataError&) {
  }
  RowFaults faults;
  try {
    const auto recording = read(log, &faults);
    check(recording, &faults);
    if (taken) require(rows(recording) == *taken && faults.total() == 0);
  } catch (const DataError&) {
    require(!taken);
  }
  require(faults.first.size() <= RowFaults::kKept * RowFault::kKinds);
}

inline LogFile log_of(LogFormat format, const std::uint8_t* data, std::size_t size) {
  LogFile log;
  log.file = "log";
  log.format = format;
  log.content = text_of(data, size);
  return log;
}

inline constexpr auto imu = [](const LogFile& log, RowFaults* faults) { return read_imu(log, faults); };
inline constexpr auto gnss = [](const LogFile& log, RowFaults* faults) { return read_gnss(log, faults); };
inline constexpr auto attitude = [](const LogFile& log, RowFaults* faults) { return read_attitude(log, faults); };

}  // namespace piste::fuzz
