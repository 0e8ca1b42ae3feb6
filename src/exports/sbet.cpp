/// Smoothed best estimate of trajectory (Applanix POSPac), 17 doubles a row, and its accuracies, 10 doubles.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>

#include "exports/formats.h"

namespace piste::export_formats {
namespace {

void append(std::string& bytes, double value) {
  auto raw = std::bit_cast<std::array<char, sizeof(double)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

void append(std::string& bytes, const Vector3d& v, double factor = 1) {
  for (const double value : v) append(bytes, factor * value);
}

// x, y, z of the columns PREFIX_{x,y,z}_UNIT; 0 if the run has none.
class OptionalTriad {
 public:
  OptionalTriad(const NumberTable& table, const std::string& prefix, const std::string& unit)
      : x_(table, prefix + "_x_" + unit), y_(table, prefix + "_y_" + unit), z_(table, prefix + "_z_" + unit) {}
  Vector3d at(std::size_t row) const { return {x_.at(row), y_.at(row), z_.at(row)}; }

 private:
  OptionalColumn x_, y_, z_;
};

}  // namespace

std::vector<ExportedFile> sbet(const ExportRun& run) {
  constexpr double kArcMinutes = 60 * kDegreesPerRadian;
  const Trajectory& track = run.track;
  const OptionalTriad force(run.table, "force", "m_s2"), rate(run.table, "rate", "deg_s");
  const bool sigmas = !track.sigma_position.empty() && !track.sigma_velocity.empty() && !track.sigma_euler.empty();
  std::string rows, accuracies;
  for (std::size_t i = 0; i < track.size(); ++i) {
    const Geodetic& place = track.place[i];
    for (const double value : {track.time[i], place.latitude, place.longitude, place.height}) append(rows, value);
    append(rows, track.velocity[i]);
    append(rows, to_euler(track.attitude[i]));
    append(rows, 0);  // wander angle
    append(rows, force.at(i));
    append(rows, rate.at(i), kDegree);
    if (!sigmas) continue;
    append(accuracies, track.time[i]);
    append(accuracies, track.sigma_position[i]);
    append(accuracies, track.sigma_velocity[i]);
    append(accuracies, track.sigma_euler[i], kArcMinutes);
  }
  std::vector<ExportedFile> files{{".out", std::move(rows)}};
  if (sigmas) files.push_back({"_smrmsg.out", std::move(accuracies)});
  return files;
}

}  // namespace piste::export_formats
