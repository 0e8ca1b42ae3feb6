#pragma once
/// Which log a file is, from its first bytes.

#include <string>
#include <string_view>

#include "piste/io/log_io.h"

namespace piste {

enum class LogKind { kImu, kGnss, kAttitude };

struct LogGuess {
  LogKind kind = LogKind::kImu;
  LogFormat format = LogFormat::kCsv;
  std::string why;  ///< what gave it away
};

/// What these bytes of a file named `file` hold. A CSV is told by its column names, rows of plain numbers by how many
/// and how large they are. Throws DataError that says what was looked for where it is none of the formats of log_io.h.
LogGuess guess_log(const std::string& file, std::string_view content);

/// Such as `GNSS`.
std::string_view name_of(LogKind kind);

}  // namespace piste
