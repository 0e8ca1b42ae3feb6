#include "model/imu_scales.h"

#include <Eigen/LU>
#include <algorithm>

namespace piste {

ImuScales::ImuScales(const FilterOptions& options) : turned_(options.unit_axes.begin(), options.unit_axes.end()) {
  for (std::size_t triad = 0; triad < 2; ++triad) {
    const TriadMember errors = triad == 0 ? &ImuSensor::gyro : &ImuSensor::accel;
    const ImuVector weights = imu_weights(options.imus, errors);
    const ErrorSplit s = split_errors(weights, imu_sigmas(options.imus, errors, ImuErrorKind::kScale));
    parts_[triad].setZero();
    parts_[triad].col(0).head(weights.size()) = weights.cwiseProduct(s.common);
    parts_[triad].block(0, 1, weights.size(), s.split.cols()) = weights.asDiagonal() * s.split;
  }
}

std::shared_ptr<const ImuScales> ImuScales::across(const FilterOptions& options) {
  const auto along = [](const Matrix3d& R) { return TurnedScale(R).at_right_angles(); };
  if (std::ranges::all_of(options.unit_axes, along)) return nullptr;
  return std::make_shared<ImuScales>(options);
}

Block ImuScales::block(std::size_t triad, std::size_t k) {
  const Block mean = triad == 0 ? Block::kGyroScale : Block::kAccelScale;
  return k == 0 ? mean : parity_block(mean, static_cast<int>(k) - 1);
}

ImuScales::Effects ImuScales::effects_of(std::size_t triad, const Vector3d& u) const {
  const auto imus = static_cast<Eigen::Index>(turned_.size());
  Effects out;
  out.fill(Matrix3d::Zero());
  for (Eigen::Index i = 0; i < imus; ++i) {
    const Matrix3d by_own = turned_[static_cast<std::size_t>(i)].by_scales(u);
    for (Eigen::Index k = 0; k < imus; ++k) out[static_cast<std::size_t>(k)] += parts_[triad](i, k) * by_own;
  }
  return out;
}

// S less s̄ on its diagonal.
Matrix3d ImuScales::rest(std::size_t triad, const Estimate& x) const {
  const auto imus = static_cast<Eigen::Index>(turned_.size());
  Matrix3d out = Matrix3d::Zero();
  for (Eigen::Index i = 0; i < imus; ++i) {
    Vector3d own = Vector3d::Zero();
    for (Eigen::Index k = 0; k < imus; ++k) {
      own += parts_[triad](i, k) * additive(x, block(triad, static_cast<std::size_t>(k)));
    }
    out += turned_[static_cast<std::size_t>(i)].effect(own);
  }
  out.diagonal() -= additive(x, block(triad, 0));
  return out;
}

ImuStep ImuScales::without_rest(const ImuStep& measured, const Estimate& x) const {
  // (1 + s̄) u from the measured signal without offsets, (1 + S) u.
  const auto own_alone = [&](std::size_t triad) -> Matrix3d {
    const Matrix3d own = (1 + additive(x, block(triad, 0)).array()).matrix().asDiagonal();
    return own * (own + rest(triad, x)).inverse();
  };
  const Matrix3d gyro = own_alone(0), accel = own_alone(1);
  const Vector3d turn = measured.dt * (x.gyro_bias + x.gyro_drift), push = measured.dt * (x.accel_bias + x.accel_drift);
  return {measured.dt, gyro * (measured.dtheta - turn) + turn, accel * (measured.dvel - push) + push,
          gyro * measured.rate_slope, accel * measured.force_slope};
}

}  // namespace piste
