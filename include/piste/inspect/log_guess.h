#pragma once
/// Guesses the kind and format of a log from its first bytes.

#include <string>
#include <string_view>

#include "piste/io/log_io.h"

namespace piste {

enum class LogKind { kImu, kGnss, kAttitude };

struct LogGuess {
  LogKind kind = LogKind::kImu;
  LogFormat format = LogFormat::kCsv;
  std::string why;  ///< what shows it
};

/// Guesses the log from the first bytes of the file `file`. A CSV is recognised by its column names, rows of plain
/// numbers by their count and size. Throws DataError that says what was looked for if it has none of the formats of
/// log_io.h.
LogGuess guess_log(const std::string& file, std::string_view content);

/// The name of a kind, such as `GNSS`.
std::string_view name_of(LogKind kind);

}  // namespace piste
