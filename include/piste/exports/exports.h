#pragma once
/// Writes the trajectory of a replay in the formats of other programs.
///
///     const ExportRun run = read_export_run("out/ski_run", {});
///     for (const ExportedFile& file : exported(run, ExportFormat::kGpx)) …  // `.gpx` and its text

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/io/solution_io.h"
#include "piste/trajectory/trajectory.h"

namespace piste {

enum class ExportFormat { kGpx, kGeojson, kNmea, kTum, kKitti, kEuroc, kSbet, kRtklib, kNumpy };

/// Its name on the command line. Throws ConfigError if there is none of that name; it says so of the formats that only
/// the Python package writes.
ExportFormat export_format(std::string_view name);
std::string_view name_of(ExportFormat format);
/// All names, separated by commas.
std::string export_format_names();
/// The extension of its file, such as `.gpx`.
std::string_view extension_of(ExportFormat format);

/// The rows of a run.
struct ExportRun {
  Trajectory track;         ///< with velocities and attitudes
  NumberTable table;        ///< all columns of numbers of its file
  std::optional<int> week;  ///< the GPS week of time_s
};

/// Reads a replay's folder: its smoothed rows, or else its filtered ones, and the week from its summary.json. `week`
/// holds if that has none. Throws DataError.
ExportRun read_export_run(const std::filesystem::path& folder, std::optional<int> week);

/// A file, called by the stem of the first one and this ending.
struct ExportedFile {
  std::string ending;  ///< such as `.gpx` or `_times.txt`
  std::string content;
};

/// The files of a run, the main one first. Times are GPS time or, in gpx, geojson and nmea, UTC. Poses are in
/// east, north, up at the first row, with the attitude of the body (forward, right, down). Heights of gpx and nmea are
/// above the geoid EGM96, with its undulation; the others are above the ellipsoid. Throws DataError if a week is needed
/// and not known, or if the run has no rows.
std::vector<ExportedFile> exported(const ExportRun& run, ExportFormat format);

/// What the format cannot hold, or breaks; a sentence each.
std::vector<std::string> losses_of(const ExportRun& run, ExportFormat format);

}  // namespace piste
