#include "io/log_week.h"

#include "io/column_reader.h"
#include "io/novatel_ascii.h"

namespace piste {

std::optional<GpsTime> first_gps_time(const LogFile& log) {
  if (log.table) return std::nullopt;
  switch (log.format) {
    case LogFormat::kColumns:
      return log_formats::first_time_columns(log);
    case LogFormat::kNmea:
      return log_formats::first_time_nmea(log);
    case LogFormat::kNovatel:
    case LogFormat::kInspva:
      return log_formats::first_time_novatel(log);
    case LogFormat::kRtklibPos:
      return log_formats::first_time_rtklib(log);
    case LogFormat::kUbx:
      return log_formats::first_time_ubx(log);
    case LogFormat::kCsv:
    case LogFormat::kKfGins:
    case LogFormat::kXsensAscii:
    case LogFormat::kImr:
      break;
  }
  return std::nullopt;
}

namespace log_formats {

std::optional<GpsTime> first_time_columns(const LogFile& log) {
  ColumnReader reader(log.file, *log.columns, log.content);
  ColumnClock clock(reader, log.columns->time, TimeOrder::kAny);
  while (reader.next()) {
    try {
      const double time = clock.next();
      if (const auto week = clock.first_week()) return GpsTime{*week, time};
      return std::nullopt;
    } catch (const RowError&) {  // a row without a time, which its reader reports
    }
  }
  return std::nullopt;
}

std::optional<GpsTime> first_time_novatel(const LogFile& log) {
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  while (reader.next()) {
    try {
      if (const auto line = novatel_log(reader)) return header_time(reader, *line);
    } catch (const RowError&) {  // as above
    }
  }
  return std::nullopt;
}

}  // namespace log_formats
}  // namespace piste
