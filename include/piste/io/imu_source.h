#pragma once
/// One IMU of a configuration: its file, its sensor, how its rows are to be taken.

#include <string>

#include "piste/core/options.h"
#include "piste/io/config.h"
#include "piste/io/log_io.h"

namespace piste {

struct ImuSource {
  LogFile log;
  ImuSensor sensor;
  ImuConditioning conditioning;
  std::string where;  ///< `FILE:LINE` of its entry
};

/// Whether a configuration is refused where a data file that it names is not there, or whoever reads the file is to say
/// so.
enum class DataFile { kMustExist, kMayBeMissing };

/// Reads the keys file, format, ignore_columns, sensor, axes, sampling and clock. Throws ConfigError.
ImuSource read_imu_source(const Config& imu, DataFile data = DataFile::kMustExist);

/// Reads the rows. Throws ConfigError where `sampling: instant` is asked of a file of increments, DataError otherwise.
ImuRecording read_imu(const ImuSource& source);

/// Reads the keys file, format and ignore_columns; `formats` are those that this kind of log has.
LogFile read_log_file(const Config& source, std::initializer_list<LogFormat> formats,
                      DataFile data = DataFile::kMustExist);

/// Refuses `log`, of the entry `source`, where it is `other` again: the same file, or a copy of it. It would count
/// twice. Throws ConfigError.
void refuse_repeated(const Config& source, const LogFile& log, const LogFile& other);

}  // namespace piste
