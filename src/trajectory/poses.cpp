/// Poses in axes of their own: TUM, KITTI and EuRoC.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>

#include "io/text_reader.h"
#include "piste/core/error.h"
#include "trajectory/formats.h"

namespace piste::trajectory_formats {
namespace {

Trajectory poses_in_own_axes() {
  Trajectory track;
  track.geodetic = false;
  return track;
}

bool is_comment(const TextReader& reader) { return reader.line().starts_with('#'); }

void require_fields(const TextReader& reader, std::size_t least, std::string_view what) {
  if (reader.fields().size() >= least) return;
  reader.fail(fmt::format("{} fields; {} are expected", reader.fields().size(), what), RowFault::Kind::kFields);
}

Vector3d vector_at(const TextReader& reader, std::size_t first) {
  return {reader.number(first), reader.number(first + 1), reader.number(first + 2)};
}

// A file has few digits, so that a quaternion has its norm only nearly.
Quaterniond unit(const TextReader& reader, double w, double x, double y, double z) {
  constexpr double kOff = 0.01;
  const Quaterniond q(w, x, y, z);
  if (!(std::abs(q.norm() - 1) < kOff)) {
    reader.fail(fmt::format("a quaternion of norm {:.6g}; 1 is expected", q.norm()));
  }
  return q.normalized();
}

// The rotation of three rows of a matrix.
Quaterniond rotation(const TextReader& reader, const Matrix3d& R) {
  constexpr double kOff = 0.01;
  if (!((R * R.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff() < kOff && R.determinant() > 0)) {
    reader.fail("the first three columns of each row of a KITTI pose must form a rotation");
  }
  return Quaterniond(R).normalized();
}

// The times of KITTI's poses, from a file next to theirs.
std::vector<double> kitti_times(const std::filesystem::path& poses) {
  for (const std::string& name : {poses.stem().string() + "_times.txt", std::string("times.txt")}) {
    const std::filesystem::path file = poses.parent_path() / name;
    if (!std::filesystem::exists(file)) continue;
    TextReader reader(file.string(), TextReader::Separator::kSpaces);
    std::vector<double> times;
    while (reader.next()) times.push_back(reader.number(0));
    return times;
  }
  return {};
}

}  // namespace

bool is_tum(const FileStart& start) { return start.numbers == 8 && !start.commas; }
bool is_kitti(const FileStart& start) { return start.numbers == 12 && !start.commas; }
bool is_euroc(const FileStart& start) {
  constexpr std::size_t kNanosecondDigits = 12;  // 1e12 ns are 1000 s; seconds of any clock have fewer digits
  return start.numbers >= 8 && start.commas && start.first_row.find_first_not_of("0123456789") >= kNanosecondDigits;
}

Trajectory read_tum(const std::string& file) {
  TextReader reader(file, TextReader::Separator::kSpaces);
  Trajectory track = poses_in_own_axes();
  IncreasingTime increasing;
  while (reader.next()) {
    if (is_comment(reader)) continue;
    require_fields(reader, 8, "the 8 of TUM, t x y z qx qy qz qw,");
    track.time.push_back(increasing.later(reader.number(0), reader));
    track.position.push_back(vector_at(reader, 1));
    track.attitude.push_back(unit(reader, reader.number(7), reader.number(4), reader.number(5), reader.number(6)));
  }
  return track;
}

Trajectory read_kitti(const std::string& file) {
  TextReader reader(file, TextReader::Separator::kSpaces);
  Trajectory track = poses_in_own_axes();
  while (reader.next()) {
    require_fields(reader, 12, "the 12 of KITTI, three rows of [R p],");
    Eigen::Matrix<double, 3, 4> pose;
    for (std::size_t i = 0; i < 12; ++i) pose(static_cast<long>(i / 4), static_cast<long>(i % 4)) = reader.number(i);
    track.position.emplace_back(pose.col(3));
    track.attitude.push_back(rotation(reader, pose.leftCols<3>()));
  }
  track.time = kitti_times(file);
  track.has_time = !track.time.empty();
  if (!track.has_time) {
    for (std::size_t i = 0; i < track.position.size(); ++i) track.time.push_back(static_cast<double>(i));
  }
  if (track.time.size() != track.position.size()) {
    throw DataError(file, fmt::format("{} poses, but {} times in the file next to them; one a pose is expected",
                                      track.position.size(), track.time.size()));
  }
  return track;
}

Trajectory read_euroc(const std::string& file) {
  constexpr double kNano = 1e-9;
  constexpr std::int64_t kSecond = 1'000'000'000;
  TextReader reader(file, TextReader::Separator::kComma);
  Trajectory track = poses_in_own_axes();
  IncreasingTime increasing;
  while (reader.next()) {
    if (is_comment(reader)) continue;
    require_fields(reader, 8, "the 8 of EuRoC, t [ns], x, y, z, qw, qx, qy, qz,");
    const auto [whole, rest] = reader.parts(0);
    const auto seconds = whole / kSecond, left = whole % kSecond;
    const double time = static_cast<double>(seconds) + kNano * (static_cast<double>(left) + rest);
    track.time.push_back(increasing.later(time, reader));
    track.position.push_back(vector_at(reader, 1));
    track.attitude.push_back(unit(reader, reader.number(4), reader.number(5), reader.number(6), reader.number(7)));
    if (reader.fields().size() > 10) track.velocity.push_back(vector_at(reader, 8));
  }
  if (track.velocity.size() != track.time.size()) track.velocity.clear();
  return track;
}

}  // namespace piste::trajectory_formats
