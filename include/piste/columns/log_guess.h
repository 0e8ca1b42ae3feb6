#pragma once
/// Guesses the kind and format of a log from its first bytes.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/io/log_io.h"

namespace piste {

enum class LogKind { kImu, kGnss, kAttitude };

struct LogGuess {
  LogKind kind = LogKind::kImu;
  LogFormat format = LogFormat::kCsv;
  std::string why;                        ///< the evidence
  std::optional<ColumnMap> columns = {};  ///< of the format columns
  /// Whether gyroscopes or accelerometers stand alone: then another file has the others. kLinear: accelerations without
  /// gravity, which may stand alone in yet another, kGravity. kNone: nothing that is used.
  enum class Part { kWhole, kGyro, kAccel, kLinear, kGravity, kNone };
  Part part = Part::kWhole;
  std::string aside = {};  ///< of a part: why another file is preferred to it, or why none needs it; or empty
  std::optional<ColumnTime> boot_time = {};  ///< of a receiver's log that has the time since power-up as well
  std::vector<std::string> doubts = {};      ///< what the user should check
  bool guessed_rates = false;                ///< of an IMU: no header states the unit of the gyroscopes
  bool guessed_sign = false;                 ///< of an IMU: the sign of the forces is not determined
  /// Pairs of the log's time and GPS seconds of week, where other rows than those of the sensor state both.
  std::vector<std::pair<double, double>> clock = {};
  std::vector<LogGuess> beside = {};  ///< other logs in the same file, such as a receiver's with an IMU's
  std::string lost = {};              ///< the part of the file that cannot be used, and why; or empty
};

/// Guesses the log from the bytes of the file `file`, mostly the first. A CSV is recognised by its column names, rows
/// of plain numbers by their count and size, and of other tables the columns are guessed. Throws DataError that names
/// the formats tried, if it has none of the formats of log_io.h.
LogGuess guess_log(const std::string& file, std::string_view content);

/// The name of a kind, such as `GNSS`.
std::string_view name_of(LogKind kind);

}  // namespace piste
