#include "piste/model/imu_parity.h"

namespace piste {

std::optional<Linearization> linearize_parity(const ParityFix& fix, int parity, TriadMember triad,
                                              const FilterOptions& options, const Estimate& x) {
  const bool gyro = triad == &ImuSensor::gyro;
  const std::optional<Parity>& measured = gyro ? fix.gyro : fix.accel;
  if (!measured) return std::nullopt;
  const Block bias = gyro ? Block::kGyroBias : Block::kAccelBias;
  const Block drift = gyro ? Block::kGyroDrift : Block::kAccelDrift;
  const Block scale = gyro ? Block::kGyroScale : Block::kAccelScale;
  const auto value = [&](Block block) -> Vector3d { return additive(x, block); };

  const std::span<const ImuSensor> imus(options.imus);
  const ImuVector noise = imu_noise(imus, triad), weights = imu_weights(noise);
  const ImuVector row = parity_rows(noise).col(parity);
  const int parities = static_cast<int>(imus.size()) - 1;
  // Derivatives by errors that do not depend on the signal: of the IMUs' mean, and of each parity block.
  struct Seen {
    Block block;
    double common;
    Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostParities> split;
  };
  const auto seen = [&](Block block, ImuErrorKind error) -> Seen {
    const ErrorSplit s = split_errors(weights, imu_sigmas(imus, triad, error));
    return {block, row.dot(s.common), row.transpose() * s.split};
  };
  const Seen offsets[] = {seen(bias, ImuErrorKind::kBias), seen(drift, ImuErrorKind::kDrift)};
  const Vector3d gain = (1 + value(scale).array()).inverse();
  const Vector3d signal = gain.cwiseProduct((gyro ? fix.rate : fix.force) - value(bias) - value(drift));

  Linearization lin;
  lin.observes = parity_block(drift, parity);
  lin.residual = measured->value;
  for (const Seen& s : offsets) {
    lin.residual -= s.common * value(s.block);
    for (int k = 0; k < parities; ++k) {
      lin.residual -= s.split(k) * value(parity_block(s.block, k));
      lin.add(parity_block(s.block, k), s.split(k) * Matrix3d::Identity());
    }
  }
  // By the scales, IMU by IMU: each acts along its own axes.
  const ErrorSplit scales = split_errors(weights, imu_sigmas(imus, triad, ImuErrorKind::kScale));
  Matrix3d difference = Matrix3d::Zero(), by_mean = Matrix3d::Zero(), by_parity[kMostParities];
  for (Matrix3d& by : by_parity) by.setZero();
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    Vector3d own = scales.common(i) * value(scale);
    for (int k = 0; k < parities; ++k) own += scales.split(i, k) * value(parity_block(scale, k));
    const auto unit = static_cast<std::size_t>(i);
    const TurnedScale turned(options.unit_axes.empty() ? Matrix3d::Identity().eval() : options.unit_axes[unit]);
    difference += row(i) * turned.effect(own);
    const Matrix3d by = row(i) * turned.by_scales(signal);
    by_mean += scales.common(i) * by;
    for (int k = 0; k < parities; ++k) by_parity[k] += scales.split(i, k) * by;
  }
  lin.residual -= difference * signal;
  const Matrix3d loss = -difference * gain.asDiagonal();  // of the signal, by an offset of the mean
  for (const Seen& s : offsets) lin.add(s.block, s.common * Matrix3d::Identity() + loss);
  lin.add(scale, by_mean + loss * signal.asDiagonal());
  for (int k = 0; k < parities; ++k) lin.add(parity_block(scale, k), by_parity[k]);

  const double density = parity_noise(noise);
  lin.covariance =
      measured->sigma.cwiseAbs2().cwiseMax(Vector3d::Constant(density * density / fix.duration)).asDiagonal();
  return lin;
}

}  // namespace piste
