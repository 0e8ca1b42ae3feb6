#include <fmt/format.h>

#include "gps_time.h"
#include "io/novatel_ascii.h"
#include "log_formats.h"
#include "piste/math/units.h"

namespace piste::log_formats {
namespace {

bool is_valid(std::string_view status) {
  return status == "INS_SOLUTION_GOOD" || status == "INS_SOLUTION_FREE" || status == "INS_ALIGNMENT_COMPLETE";
}

}  // namespace

AttitudeRecording read_attitude_inspva(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  AttitudeRecording attitude{log.file, {}};
  WeekTime times(log.order());
  const auto degrees = [&](std::size_t field) -> Vector3d {
    return kDegree * Vector3d(reader.number(field), reader.number(field + 1), reader.number(field + 2));
  };
  const auto row = [&] {
    const auto line = novatel_log(reader);
    if (!line) return;
    const bool extended = line->name == "INSPVAXA" || line->name == "INSPVAXSA";
    if (!extended && line->name != "INSPVAA" && line->name != "INSPVASA") return;
    GpsTime time = extended ? header_time(reader, *line) : GpsTime{};
    split_fields(reader, *line, extended ? 23 : 12);
    if (!is_valid(reader.fields()[extended ? 0 : 11])) {
      ++attitude.not_valid;
      return;
    }
    if (!extended) time = time_of(reader, 0);
    if (!extended && !log.sigma && is_for_use(faults)) {
      reader.fail(
          fmt::format("{} has no sigmas; state them in the configuration: `sigma: 0.05 0.05 0.1 deg` (roll, "
                      "pitch, heading), or log INSPVAXA",
                      line->name));
    }
    EulerFix fix;
    fix.angles = degrees(extended ? 9 : 8);
    fix.sigma = extended ? degrees(18) : unknown_sigma();
    check_attitude(fix, log, reader);
    fix.time = times.next(time, reader);
    attitude.fixes.push_back(fix);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return attitude;
}

}  // namespace piste::log_formats
