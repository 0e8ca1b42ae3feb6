/// Poses in east, north, up: TUM, KITTI and EuRoC.

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "exports/formats.h"

namespace piste::export_formats {

std::vector<ExportedFile> tum(const ExportRun& run) {
  std::string text = "# time_s x y z qx qy qz qw; east, north, up at the first row; body forward, right, down\n";
  for (const Pose& p : poses_of(run)) {
    const Quaterniond& q = p.attitude;
    fmt::format_to(std::back_inserter(text), "{:.6f} {:.6f} {:.6f} {:.6f} {:.12f} {:.12f} {:.12f} {:.12f}\n", p.time,
                   p.position.x(), p.position.y(), p.position.z(), q.x(), q.y(), q.z(), q.w());
  }
  return {{".tum", std::move(text)}};
}

std::vector<ExportedFile> kitti(const ExportRun& run) {
  std::string text, times;
  for (const Pose& p : poses_of(run)) {
    const Matrix3d R = p.attitude.toRotationMatrix();
    for (int i = 0; i < 3; ++i) {
      fmt::format_to(std::back_inserter(text), "{:.12f} {:.12f} {:.12f} {:.6f}{}", R(i, 0), R(i, 1), R(i, 2),
                     p.position[i], i < 2 ? ' ' : '\n');
    }
    fmt::format_to(std::back_inserter(times), "{:.6f}\n", p.time);
  }
  return {{".txt", std::move(text)}, {"_times.txt", std::move(times)}};
}

std::vector<ExportedFile> euroc(const ExportRun& run) {
  std::string text = "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  for (const Pose& p : poses_of(run)) {
    const Quaterniond& q = p.attitude;
    const std::int64_t micro = std::llround(1e6 * p.time);  // files have whole microseconds
    fmt::format_to(std::back_inserter(text), "{},{:.6f},{:.6f},{:.6f},{:.12f},{:.12f},{:.12f},{:.12f}\n", 1000 * micro,
                   p.position.x(), p.position.y(), p.position.z(), q.w(), q.x(), q.y(), q.z());
  }
  return {{".csv", std::move(text)}};
}

}  // namespace piste::export_formats
