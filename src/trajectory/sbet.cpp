/// Smoothed best estimate of trajectory (Applanix POSPac), and its accuracies.

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "io/byte_reader.h"
#include "io/text_reader.h"
#include "piste/core/error.h"
#include "piste/math/units.h"
#include "trajectory/formats.h"

namespace piste::trajectory_formats {
namespace {

constexpr std::size_t kSbetDoubles = 17, kAccuracyDoubles = 10;

// The doubles of a file in rows of a fixed length.
class DoubleRows {
 public:
  DoubleRows(const std::string& file, std::size_t columns) : bytes_(file), columns_(columns) {
    if (bytes_.text().size() % (8 * columns) == 0) return;
    throw DataError(
        file, fmt::format("{} bytes are no whole rows of {} doubles; is the file cut?", bytes_.text().size(), columns));
  }
  std::size_t size() const { return bytes_.text().size() / (8 * columns_); }
  double at(std::size_t row, std::size_t column) const {
    return log_formats::number_at<double>(bytes_.text(), 8 * (row * columns_ + column));
  }
  Vector3d three(std::size_t row, std::size_t column) const {
    return {at(row, column), at(row, column + 1), at(row, column + 2)};
  }

 private:
  MappedFile bytes_;
  std::size_t columns_;
};

// The accuracies in STEM_smrmsg.out, next to STEM.out, if it is there. Its rows may be fewer: each holds until the
// next.
void add_accuracies(Trajectory& track, const std::filesystem::path& file) {
  constexpr double kArcMinute = kDegree / 60;
  const std::filesystem::path accuracies = file.parent_path() / (file.stem().string() + "_smrmsg.out");
  if (!std::filesystem::exists(accuracies)) return;
  const DoubleRows rows(accuracies.string(), kAccuracyDoubles);
  if (rows.size() == 0) return;
  std::size_t row = 0;
  for (const double time : track.time) {
    while (row + 1 < rows.size() && rows.at(row + 1, 0) <= time + 1e-6) ++row;
    track.sigma_position.push_back(rows.three(row, 1));
    track.sigma_velocity.push_back(rows.three(row, 4));
    track.sigma_euler.emplace_back(kArcMinute * rows.three(row, 7));
  }
}

}  // namespace

// Binary rows whose first has a latitude and a longitude in radians.
bool is_sbet(const FileStart& start) {
  constexpr std::size_t kRow = 8 * kSbetDoubles;
  if (start.size < kRow || start.size % kRow != 0) return false;
  const auto time = log_formats::number_at<double>(start.text, 0),
             latitude = log_formats::number_at<double>(start.text, 8),
             longitude = log_formats::number_at<double>(start.text, 16);
  return std::abs(time) < 1e10 && std::abs(latitude) <= kDegree * 90 && std::abs(longitude) <= kDegree * 360;
}

Trajectory read_sbet(const std::string& file) {
  const DoubleRows rows(file, kSbetDoubles);
  Trajectory track;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows.three(i, 0).allFinite() || !rows.three(i, 3).allFinite()) {
      throw DataError(fmt::format("{}: row {}", file, i), "a value is not finite; is the file an SBET?");
    }
    track.time.push_back(rows.at(i, 0));
    track.place.push_back({rows.at(i, 1), rows.at(i, 2), rows.at(i, 3)});
    // Horizontal velocities and the heading are against axes turned from north by the wander angle.
    const double wander = rows.at(i, 10), c = std::cos(wander), s = std::sin(wander);
    const Vector3d v = rows.three(i, 4), angles = rows.three(i, 7);
    track.velocity.emplace_back(c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z());
    track.attitude.push_back(from_euler({angles.x(), angles.y(), angles.z() - wander}));
  }
  add_accuracies(track, file);
  return track;
}

}  // namespace piste::trajectory_formats
