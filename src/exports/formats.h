#pragma once
/// The writers behind exports.h, one file each.

#include <functional>
#include <string>
#include <vector>

#include "math/gps_time.h"
#include "piste/exports/exports.h"
#include "piste/math/units.h"

namespace piste::export_formats {

std::vector<ExportedFile> gpx(const ExportRun& run);
std::vector<ExportedFile> geojson(const ExportRun& run);
std::vector<ExportedFile> nmea(const ExportRun& run);
std::vector<ExportedFile> tum(const ExportRun& run);
std::vector<ExportedFile> kitti(const ExportRun& run);
std::vector<ExportedFile> euroc(const ExportRun& run);
std::vector<ExportedFile> sbet(const ExportRun& run);
std::vector<ExportedFile> rtklib(const ExportRun& run);
std::vector<ExportedFile> numpy(const ExportRun& run);

/// GPS time of row i. @pre the week is known
inline GpsTime gps_time_of(const ExportRun& run, std::size_t i) { return {*run.week, run.track.time[i]}; }

/// A column of the table, or 0 where it is missing: row i.
class OptionalColumn {
 public:
  OptionalColumn(const NumberTable& table, std::string_view name);
  bool is_there() const { return column_ < columns_; }
  double at(std::size_t row) const { return is_there() ? table_.values[row * columns_ + column_] : 0; }

 private:
  const NumberTable& table_;
  std::size_t columns_, column_;
};

/// A pose in the axes of the export.
struct Pose {
  double time = 0;
  Vector3d position;
  Quaterniond attitude;
};
/// In east, north, up at the first row; the quaternion's w is not negative.
std::vector<Pose> poses_of(const ExportRun& run);

}  // namespace piste::export_formats
