#pragma once
/// Marks: instants that a receiver or a camera noted.

#include <optional>
#include <string>
#include <vector>

#include "piste/math/earth.h"

namespace piste {

enum class MarkFormat {
  kCsv,        ///< `time_s`, or `time_utc` such as 2022-03-09T11:59:42.5Z; optional `name` and a place
  kUbx,        ///< TIM-TM2: rising edges of the external interrupt
  kNovatel,    ///< MARKTIMEA, MARKPOSA, MARK1PVAA and the like
  kRtklibPos,  ///< `_events.pos`
  kExif        ///< a photograph (JPEG), or a folder of them: DateTimeOriginal, taken as UTC without a zone
};

/// A file of marks.
struct MarkFile {
  std::string file;
  MarkFormat format = MarkFormat::kCsv;
};

/// One mark.
struct Mark {
  std::string name;
  double time = 0;                               ///< s of the GPS week of the run
  std::optional<Geodetic> place = std::nullopt;  ///< where what it marks was, if the file says so
};

/// The marks in the order of the file. Marks without a name are called mark_1 and so on. `week`: that of the run;
/// `near`: a time of the run, to whose week times of week are brought. Throws DataError `FILE:LINE: …`, also if a date
/// needs the week and it is not known.
std::vector<Mark> read_marks(const MarkFile& from, std::optional<int> week, double near);

}  // namespace piste
