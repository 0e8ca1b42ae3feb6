#include <fmt/format.h>

#include <array>
#include <cmath>

#include "math/linear_algebra.h"
#include "piste/core/error.h"
#include "piste/evaluate/evaluation.h"

namespace piste {
namespace {

constexpr std::array<std::pair<std::string_view, AlignmentKind>, 5> kKinds{{{"none", AlignmentKind::kNone},
                                                                            {"position", AlignmentKind::kPosition},
                                                                            {"yaw", AlignmentKind::kYaw},
                                                                            {"se3", AlignmentKind::kSe3},
                                                                            {"sim3", AlignmentKind::kSim3}}};

Vector3d mean_of(const std::vector<Vector3d>& points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

// The angle about the third axis that maximises the sum of b · R a: tan = (c_yx − c_xy) / (c_xx + c_yy) of
// C = Σ b aᵀ.
Matrix3d yaw_of(const Matrix3d& C) {
  const double angle = std::atan2(C(1, 0) - C(0, 1), C(0, 0) + C(1, 1));
  return Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

std::string_view name_of(AlignmentKind kind) { return kKinds[static_cast<std::size_t>(kind)].first; }

AlignmentKind alignment_kind(std::string_view name) {
  for (const auto& [known, kind] : kKinds) {
    if (known == name) return kind;
  }
  throw ConfigError("--align", fmt::format("`{}` is none of: none, position, yaw, se3, sim3", name));
}

// Umeyama 1991, equations 34 to 43.
Similarity align_points(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b, AlignmentKind kind) {
  Similarity motion;
  if (kind == AlignmentKind::kNone) return motion;
  const auto few = [](std::string_view what) { throw DataError("", fmt::format("{}; choose --align position", what)); };
  if (a.empty()) throw DataError("", "no point to align; choose --align none");
  if (a.size() < 2 && kind != AlignmentKind::kPosition) few("one point determines no rotation");
  const Vector3d mean_a = mean_of(a), mean_b = mean_of(b);
  Matrix3d C = Matrix3d::Zero();
  double spread = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    C += (b[i] - mean_b) * (a[i] - mean_a).transpose();
    spread += (a[i] - mean_a).squaredNorm();
  }
  if (kind == AlignmentKind::kYaw) {
    if (!(C.topLeftCorner<2, 2>().norm() > 0)) few("points on one vertical determine no yaw");
    motion.rotation = yaw_of(C);
  } else if (kind != AlignmentKind::kPosition) {
    const SingularValues svd = singular_values(C);
    constexpr double kFlat = 1e-12;
    if (!(svd.values(1) > kFlat * svd.values(0))) few("points on one line determine no rotation");
    Vector3d sign(1, 1, 1);
    if (svd.U.determinant() * svd.V.determinant() < 0) sign.z() = -1;
    motion.rotation = svd.U * sign.asDiagonal() * svd.V.transpose();
    if (kind == AlignmentKind::kSim3) motion.scale = svd.values.dot(sign) / spread;
  }
  motion.translation = mean_b - motion.scale * (motion.rotation * mean_a);
  return motion;
}

}  // namespace piste
