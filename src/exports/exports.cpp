#include "piste/exports/exports.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "evaluate/path.h"
#include "exports/formats.h"
#include "io/csv.h"
#include "piste/core/error.h"
#include "piste/io/config.h"

namespace piste {
namespace {

namespace formats = export_formats;

struct Writer {
  ExportFormat format;
  std::string_view name, extension;
  bool needs_week;
  std::vector<ExportedFile> (*write)(const ExportRun&);
  std::string_view loses;  ///< a sentence, or empty
};

constexpr std::string_view kNoSigmas = "has no place for sigmas, velocities and attitudes";
constexpr std::string_view kPoses = "has no place for sigmas, velocities and the place on the Earth";
constexpr std::array kWriters = std::to_array<Writer>({
    {ExportFormat::kGpx, "gpx", ".gpx", true, formats::gpx, kNoSigmas},
    {ExportFormat::kGeojson, "geojson", ".geojson", true, formats::geojson, kNoSigmas},
    {ExportFormat::kNmea, "nmea", ".nmea", true, formats::nmea,
     "has sentences longer here than its 82 characters, for minutes of 7 decimals and microseconds; it has no place "
     "for "
     "sigmas, the vertical velocity and attitudes"},
    {ExportFormat::kTum, "tum", ".tum", false, formats::tum, kPoses},
    {ExportFormat::kKitti, "kitti", ".txt", false, formats::kitti,
     "has no place for sigmas, velocities and the place on the Earth; times stand in a second file"},
    {ExportFormat::kEuroc, "euroc", ".csv", false, formats::euroc, kPoses},
    {ExportFormat::kSbet, "sbet", ".out", false, formats::sbet, "has no place for the GPS week"},
    {ExportFormat::kRtklib, "rtklib", ".pos", true, formats::rtklib,
     "has no place for attitudes; its quality flag is 5 (single) in each row"},
    {ExportFormat::kNumpy, "numpy", ".npz", false, formats::numpy, ""},
});

const Writer& writer_of(ExportFormat format) {
  return *std::find_if(kWriters.begin(), kWriters.end(), [&](const Writer& w) { return w.format == format; });
}

// All columns of numbers. Those of text, such as time_utc, are left out.
NumberTable numbers_of(const std::string& file) {
  CsvReader csv(file);
  NumberTable table;
  std::vector<std::size_t> columns;
  for (const std::string& name : csv.names()) {
    if (name == "time_utc") continue;
    table.names.push_back(name);
    columns.push_back(csv.column(name));
  }
  RowFaults skipped;
  csv.finish_header(&skipped);
  while (csv.next()) {
    for (const std::size_t column : columns) table.values.push_back(csv[column]);
  }
  return table;
}

// The member of summary.json, which is YAML too.
std::optional<int> week_of(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "summary.json";
  if (!std::filesystem::exists(file)) return std::nullopt;
  const Config summary = Config::load(file);
  if (!summary.has("gps_week")) return std::nullopt;
  return static_cast<int>(summary.integer("gps_week"));
}

}  // namespace

ExportFormat export_format(std::string_view name) {
  for (const Writer& writer : kWriters) {
    if (writer.name == name) return writer.format;
  }
  const bool python = name == "parquet" || name == "rosbag" || name == "ros2" || name == "mcap";
  throw ConfigError("--to", fmt::format("`{}` is none of: {}{}", name, export_format_names(),
                                        python ? "; parquet and rosbag are written from Python: "
                                                 "piste.export(run, \"parquet\")"
                                               : ""));
}

std::string_view name_of(ExportFormat format) { return writer_of(format).name; }

std::string export_format_names() {
  std::vector<std::string_view> names;
  names.reserve(std::size(kWriters));
  for (const Writer& writer : kWriters) names.push_back(writer.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string_view extension_of(ExportFormat format) { return writer_of(format).extension; }

ExportRun read_export_run(const std::filesystem::path& folder, std::optional<int> week) {
  if (!std::filesystem::is_directory(folder)) {
    throw DataError(folder.string(), "is no folder; name the output folder of a replay");
  }
  ExportRun run;
  run.track = read_trajectory({.path = folder, .format = TrajectoryFormat::kCsv});
  if (run.track.velocity.empty() || run.track.attitude.empty()) {
    throw DataError(run.track.file + ":1", "has no velocities or attitudes; smoothed.csv of a replay has both");
  }
  run.table = numbers_of(run.track.file);
  run.week = week_of(folder);
  if (!run.week) run.week = week;
  return run;
}

std::vector<ExportedFile> exported(const ExportRun& run, ExportFormat format) {
  const Writer& writer = writer_of(format);
  if (writer.needs_week && !run.week) {
    throw DataError(run.track.file,
                    fmt::format("{} has dates, and the GPS week of this run is not known, as its logs do not state it; "
                                "give it: --week 2374",
                                writer.name));
  }
  return writer.write(run);
}

std::vector<std::string> losses_of(const ExportRun& run, ExportFormat format) {
  const Writer& writer = writer_of(format);
  std::vector<std::string> said;
  if (!writer.loses.empty()) said.push_back(fmt::format("{} {}", writer.name, writer.loses));
  const bool force = formats::OptionalColumn(run.table, "force_x_m_s2").is_there();
  if (format == ExportFormat::kSbet && !force) {
    said.emplace_back(
        "the specific force and rate of the body are 0, as the run has no columns of them; write them with "
        "`output: {columns: [rates]}`");
  }
  return said;
}

namespace export_formats {

OptionalColumn::OptionalColumn(const NumberTable& table, std::string_view name)
    : table_(table),
      columns_(table.names.size()),
      column_(static_cast<std::size_t>(std::find(table.names.begin(), table.names.end(), name) - table.names.begin())) {
}

std::vector<Pose> poses_of(const ExportRun& run) {
  const FramedPath path(run.track, EnuFrame(run.track.place.front()));
  std::vector<Pose> poses;
  poses.reserve(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    const FramedRow row = path.row(i);
    Quaterniond q = row.attitude.normalized();
    if (q.w() < 0) q.coeffs() *= -1;
    poses.push_back({row.time, row.position, q});
  }
  return poses;
}

}  // namespace export_formats
}  // namespace piste
