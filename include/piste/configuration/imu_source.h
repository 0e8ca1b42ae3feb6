#pragma once
/// Reads one IMU of a configuration: its file, its sensor, and how its rows are conditioned.

#include <string>

#include "piste/core/options.h"
#include "piste/io/config.h"
#include "piste/io/log_io.h"

namespace piste {

/// An IMU of a configuration.
struct ImuSource {
  LogFile log;
  ImuSensor sensor;
  ImuConditioning conditioning;
  std::string where;  ///< `FILE:LINE` of its entry
};

/// Whether a missing data file is an error of the configuration, or only an error when the file is read.
enum class DataFile { kMustExist, kMayBeMissing };

/// Reads an IMU's keys: file, format, ignore_columns, repair, stamps, sensor, axes, sampling and clock; for columns
/// also columns and accel_file. Throws ConfigError.
ImuSource read_imu_source(const Config& imu, DataFile data = DataFile::kMustExist);

/// Reads the rows of the file. Throws ConfigError if the configuration says `sampling: instant` and the file has
/// increments. All other errors are DataError.
ImuRecording read_imu(const ImuSource& source);

/// Reads a log's keys: file, format, ignore_columns and repair. `formats`: the formats that are allowed. Throws
/// ConfigError.
LogFile read_log_file(const Config& source, std::initializer_list<LogFormat> formats,
                      DataFile data = DataFile::kMustExist);

/// Whether two files are one, or one is a copy of the other.
bool is_same_log(const std::string& a, const std::string& b);

/// Throws ConfigError if `log`, of the entry `source`, is the same file as `other` or a copy of it: its measurements
/// would count twice.
void refuse_repeated(const Config& source, const LogFile& log, const LogFile& other);

}  // namespace piste
