#include "diagnosis/imu_places.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "math/linear_algebra.h"
#include "piste/math/so3.h"

namespace piste {

std::optional<ImuOffset> imu_offset(const ImuOutputs& forces, std::size_t imu) {
  // p, biases, and a matrix by rows.
  constexpr Eigen::Index kPlace = 0, kBias = 3, kMatrix = 6, kColumns = 15;
  constexpr int kFewestMeans = 30, kTogether = 5;  // windows of a mean, in which vibration cancels
  using Rows = Eigen::Matrix<double, 3, kColumns>;
  const Outputs &first = forces.of_imus.front(), &own = forces.of_imus[imu];
  const auto row_of = [&](std::size_t w) -> std::optional<Rows> {
    const double apart = forces.time[w + 1] - forces.time[w - 1];
    if (apart > 2.5 * forces.duration) return std::nullopt;
    const Vector3d turning = (forces.rate[w + 1] - forces.rate[w - 1]) / apart;
    const Matrix3d rate = skew(forces.rate[w]);
    Rows rows = Rows::Zero();
    rows.middleCols<3>(kPlace) = skew(turning) + rate * rate;
    rows.middleCols<3>(kBias).setIdentity();
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      rows.block<1, 3>(axis, kMatrix + 3 * axis) = first.col(static_cast<Eigen::Index>(w)).transpose();
    return rows;
  };
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kColumns, kColumns);
  Eigen::VectorXd projected = Eigen::VectorXd::Zero(kColumns);
  double squares = 0;
  Eigen::Index means = 0;
  int summed = 0;
  Rows rows_sum = Rows::Zero();
  Vector3d apart_sum = Vector3d::Zero();
  for (std::size_t w = 1; w + 1 < forces.time.size(); ++w) {
    const auto rows = row_of(w);
    if (!rows) continue;
    const auto column = static_cast<Eigen::Index>(w);
    rows_sum += *rows / kTogether;
    apart_sum += (own.col(column) - first.col(column)) / kTogether;
    if (++summed < kTogether) continue;
    information += rows_sum.transpose() * rows_sum;
    projected += rows_sum.transpose() * apart_sum;
    squares += apart_sum.squaredNorm();
    ++means;
    summed = 0;
    rows_sum.setZero();
    apart_sum.setZero();
  }
  if (means < kFewestMeans) return std::nullopt;
  const Eigen::VectorXd found = solve_symmetric(information, projected);
  const double left = std::max(0.0, squares - found.dot(projected)) / static_cast<double>(3 * means - kColumns);
  const Eigen::VectorXd variance = left * inverse(information).diagonal();
  return ImuOffset{found.segment<3>(kPlace), variance.segment<3>(kPlace).cwiseSqrt()};
}

}  // namespace piste
