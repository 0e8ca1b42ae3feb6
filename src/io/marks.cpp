#include "piste/io/marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "io/exif.h"
#include "io/log_week.h"
#include "io/novatel_ascii.h"
#include "io/text_reader.h"
#include "math/time.h"
#include "piste/core/error.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// Times of GPS as seconds of the run's week.
class RunTime {
 public:
  RunTime(std::optional<int> week, double near) : week_(week), near_(near) {}
  // Of a date: the week must be known.
  double dated(const GpsTime& time, const std::string& where) const {
    if (!week_) {
      throw DataError(where, "the mark has a date, and the GPS week of the run is not known; state it: `week: 2374`");
    }
    return (time.week - *week_) * kWeek + time.seconds;
  }
  // Of a week and its seconds: without the run's week, that of the run.
  double of_week(const GpsTime& time, const std::string& where) const {
    return week_ ? dated(time, where) : time.seconds + kWeek * std::round((near_ - time.seconds) / kWeek);
  }

 private:
  std::optional<int> week_;
  double near_;
};

// Of a time such as 2022-03-09T11:59:42.5Z.
GpsTime utc_of(const TextReader& reader, std::string_view text) {
  const auto number = [&](std::size_t from, std::size_t length) {
    const auto value =
        from < text.size() ? number_in(text.substr(from, length), TextReader::Separator::kComma) : std::nullopt;
    if (!value) reader.fail(fmt::format("`{}` is no time; right would be 2022-03-09T11:59:42.5Z", text));
    return *value;
  };
  if (text.ends_with('Z')) text.remove_suffix(1);
  const auto day = day_of(number(0, 4), number(5, 2), number(8, 2));
  if (!day) reader.fail(fmt::format("`{}` is no date", text.substr(0, 10)));
  return gps_time(*day, number(11, 2) * kHour + number(14, 2) * 60 + number(17, text.size()), TimeSystem::kUtc);
}

std::vector<Mark> marks_of_csv(const std::string& file, const RunTime& run) {
  TextReader reader(file, TextReader::Separator::kComma);
  if (!reader.next())
    throw DataError(file + ":1", "the file is empty; a header line that names the columns is expected");
  const std::vector<std::string> names(reader.fields().begin(), reader.fields().end());
  const auto find = [&](std::string_view name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const std::size_t seconds = find("time_s"), utc = find("time_utc"), name = find("name");
  const std::array place{find("latitude_deg"), find("longitude_deg"), find("height_m")};
  const bool has_places = std::ranges::all_of(place, [&](std::size_t column) { return column < names.size(); });
  if (seconds == names.size() && utc == names.size()) {
    throw DataError(file + ":1", "column time_s or time_utc is missing");
  }
  std::vector<Mark> marks;
  while (reader.next()) {
    if (reader.fields().size() != names.size()) {
      reader.fail(fmt::format("{} fields, but the header names {} columns; is the line cut?", reader.fields().size(),
                              names.size()),
                  RowFault::Kind::kFields);
    }
    Mark mark;
    if (name < names.size()) mark.name = reader.fields()[name];
    mark.time = seconds < names.size() ? reader.number(seconds, "time_s")
                                       : run.dated(utc_of(reader, reader.fields()[utc]), reader.where());
    if (has_places && !reader.fields()[place[0]].empty()) {
      mark.place = Geodetic{kDegree * reader.number(place[0], "latitude_deg"),
                            kDegree * reader.number(place[1], "longitude_deg"), reader.number(place[2], "height_m")};
    }
    marks.push_back(mark);
  }
  return marks;
}

std::vector<Mark> marks_of_novatel(const std::string& file, const RunTime& run) {
  TextReader reader(file, TextReader::Separator::kComma);
  std::vector<Mark> marks;
  while (reader.next()) {
    const auto line = log_formats::novatel_log(reader);
    if (!line || !line->name.starts_with("MARK")) continue;
    GpsTime time = log_formats::header_time(reader, *line);
    if (line->name.find("TIME") != std::string_view::npos) {  // the body has the instant in full
      reader.split(line->body);
      if (reader.fields().size() < 2) reader.fail("week and seconds are missing; is the line cut?");
      time = log_formats::time_of(reader, 0);
    }
    marks.push_back({"", run.of_week(time, reader.where())});
  }
  return marks;
}

std::vector<Mark> marks_of_rtklib(const std::string& file, const RunTime& run) {
  const LogFile log{.file = file, .format = LogFormat::kRtklibPos};
  RowFaults faults;
  const GnssRecording gnss = read_gnss(log, &faults);
  if (!faults.first.empty()) throw DataError(faults.error_at, faults.first.front().what);
  const auto first = first_gps_time(log);
  std::vector<Mark> marks;
  for (const GeodeticFix& fix : gnss.fixes) {
    marks.push_back({"", first ? run.of_week({first->week, fix.time}, file) : fix.time});
  }
  return marks;
}

// A photograph or all of a folder, in the order of their names.
std::vector<Mark> marks_of_photographs(const std::string& file, const RunTime& run) {
  namespace fs = std::filesystem;
  std::vector<fs::path> photographs;
  if (fs::is_directory(file)) {
    for (const auto& entry : fs::directory_iterator(file)) {
      std::string extension = entry.path().extension().string();
      std::transform(extension.begin(), extension.end(), extension.begin(),
                     [](unsigned char c) { return std::tolower(c); });
      if (extension == ".jpg" || extension == ".jpeg") photographs.push_back(entry.path());
    }
    std::sort(photographs.begin(), photographs.end());
    if (photographs.empty()) throw DataError(file, "holds no photograph (.jpg)");
  } else {
    photographs.emplace_back(file);
  }
  std::vector<Mark> marks;
  marks.reserve(photographs.size());
  for (const fs::path& photograph : photographs) {
    marks.push_back({photograph.filename().string(), run.dated(exif_time(photograph.string()), photograph.string())});
  }
  return marks;
}

std::vector<Mark> marks_of_ubx(const std::string& file, const RunTime& run) {
  std::vector<Mark> marks;
  for (const GpsTime& time : log_formats::ubx_marks({.file = file, .format = LogFormat::kUbx})) {
    marks.push_back({"", run.of_week(time, file)});
  }
  return marks;
}

}  // namespace

std::vector<Mark> read_marks(const MarkFile& from, std::optional<int> week, double near) {
  const RunTime run(week, near);
  std::vector<Mark> marks;
  switch (from.format) {
    case MarkFormat::kCsv:
      marks = marks_of_csv(from.file, run);
      break;
    case MarkFormat::kUbx:
      marks = marks_of_ubx(from.file, run);
      break;
    case MarkFormat::kNovatel:
      marks = marks_of_novatel(from.file, run);
      break;
    case MarkFormat::kRtklibPos:
      marks = marks_of_rtklib(from.file, run);
      break;
    case MarkFormat::kExif:
      marks = marks_of_photographs(from.file, run);
      break;
  }
  if (marks.empty()) throw DataError(from.file, "holds no mark");
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i].name.empty()) marks[i].name = fmt::format("mark_{}", i + 1);
  }
  return marks;
}

}  // namespace piste
