#include "piste/trajectory/trajectory.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "io/text_reader.h"
#include "piste/core/error.h"
#include "trajectory/formats.h"

namespace piste {
namespace {

namespace formats = trajectory_formats;

struct Reader {
  TrajectoryFormat format;
  std::string_view name;
  bool (*recognises)(const formats::FileStart&);
  Trajectory (*read)(const std::string&);
};

// Those whose sign is unmistakable come first.
constexpr std::array kReaders = std::to_array<Reader>({
    {TrajectoryFormat::kMapping, "mapping", formats::is_mapping, formats::read_mapping},
    {TrajectoryFormat::kCsv, "csv", formats::is_csv, formats::read_csv},
    {TrajectoryFormat::kNmea, "nmea", formats::is_nmea, formats::read_nmea},
    {TrajectoryFormat::kRtklibPos, "rtklib_pos", formats::is_rtklib, formats::read_rtklib},
    {TrajectoryFormat::kInertialExplorer, "inertial_explorer", formats::is_inertial_explorer,
     formats::read_inertial_explorer},
    {TrajectoryFormat::kEuroc, "euroc", formats::is_euroc, formats::read_euroc},
    {TrajectoryFormat::kTum, "tum", formats::is_tum, formats::read_tum},
    {TrajectoryFormat::kKitti, "kitti", formats::is_kitti, formats::read_kitti},
    {TrajectoryFormat::kKfGins, "kf_gins", formats::is_kf_gins, formats::read_kf_gins},
    {TrajectoryFormat::kSbet, "sbet", formats::is_sbet, formats::read_sbet},
});

const Reader& reader_of(TrajectoryFormat format) {
  return *std::find_if(kReaders.begin(), kReaders.end(), [&](const Reader& r) { return r.format == format; });
}

// Counts the numbers of a line; 0 if anything else stands in it.
std::size_t count_numbers(std::string_view line) {
  constexpr std::string_view kGaps = " \t,;\r";
  std::size_t count = 0;
  for (std::size_t at = line.find_first_not_of(kGaps); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kGaps, at), line.size());
    if (!number_in(line.substr(at, end - at), TextReader::Separator::kSpaces)) return 0;
    ++count;
    at = line.find_first_not_of(kGaps, end);
  }
  return count;
}

formats::FileStart start_of(const std::filesystem::path& path, const MappedFile& file) {
  constexpr std::size_t kLooked = 1 << 14;  // bytes
  formats::FileStart start;
  start.path = path;
  start.size = file.text().size();
  start.text = file.text().substr(0, kLooked);
  for (std::string_view rest = start.text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const bool empty = line.find_first_not_of(" \t\r") == std::string_view::npos;
    if (empty || line.starts_with('#') || line.starts_with('%')) continue;
    start.first_row = line;
    break;
  }
  start.numbers = count_numbers(start.first_row);
  start.commas = start.first_row.find(',') != std::string_view::npos;
  return start;
}

// The file of a path that may be the folder of a replay.
std::filesystem::path file_of(const TrajectoryFile& from) {
  std::filesystem::path file = from.path;
  if (std::filesystem::is_directory(file)) {
    file = from.path / "smoothed.csv";
    if (!std::filesystem::exists(file)) file = from.path / "filtered.csv";
    if (!std::filesystem::exists(file)) {
      throw DataError(from.path.string(), "holds neither smoothed.csv nor filtered.csv; name the folder of a replay");
    }
  }
  if (from.at.empty()) return file;
  std::filesystem::path point =
      file.parent_path() / fmt::format("{}_{}{}", file.stem().string(), from.at, file.extension().string());
  if (!std::filesystem::exists(point)) {
    throw DataError(point.string(), fmt::format("is not there; state the point `{0}` in the replay's configuration: "
                                                "`output: {{at: {{{0}: 0 0 -0.4 m}}}}`",
                                                from.at));
  }
  return point;
}

void require_increasing(const Trajectory& track) {
  if (track.time.empty()) throw DataError(track.file + ":1", "holds no row of a trajectory");
  const auto back = std::adjacent_find(track.time.begin(), track.time.end(), [](double a, double b) { return a >= b; });
  if (back == track.time.end()) return;
  throw DataError(track.file, fmt::format("time {:.6f} s does not increase, the row before is at {:.6f} s; sort the "
                                          "rows and keep each time once",
                                          *std::next(back), *back));
}

}  // namespace

std::string_view name_of(TrajectoryFormat format) { return reader_of(format).name; }

std::string trajectory_format_names() {
  std::vector<std::string_view> names;
  names.reserve(std::size(kReaders));
  for (const Reader& reader : kReaders) names.push_back(reader.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

TrajectoryFormat trajectory_format(std::string_view name) {
  for (const Reader& reader : kReaders) {
    if (reader.name == name) return reader.format;
  }
  throw ConfigError("",
                    fmt::format("`{}` is no format of a trajectory; known are: {}", name, trajectory_format_names()));
}

Trajectory read_trajectory(const TrajectoryFile& from) {
  const std::filesystem::path path = file_of(from);
  const std::string file = path.string();
  const Reader* reader = from.format ? &reader_of(*from.format) : nullptr;
  if (reader == nullptr) {
    const MappedFile bytes(file);
    const formats::FileStart start = start_of(path, bytes);
    if (start.size == 0) throw DataError(file + ":1", "the file is empty; a trajectory is expected");
    for (const Reader& r : kReaders) {
      if (reader == nullptr && r.recognises(start)) reader = &r;
    }
  }
  if (reader == nullptr) {
    throw DataError(file + ":1", fmt::format("no format of a trajectory is recognised; known are: {}. A table with "
                                             "other names is described by a configuration with the keys `gnss` and "
                                             "`attitude`",
                                             trajectory_format_names()));
  }
  Trajectory track = reader->read(file);
  track.file = file;
  track.format = reader->format;
  require_increasing(track);
  return track;
}

}  // namespace piste
