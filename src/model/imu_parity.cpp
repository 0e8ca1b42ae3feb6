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

  const std::span<const ImuSensor> units(options.units);
  const UnitVector noise = unit_noise(units, triad), weights = unit_weights(noise);
  const UnitVector row = parity_rows(noise).col(parity);
  const int parities = static_cast<int>(units.size()) - 1;
  // What is seen of an error: of the units' mean, and of each parity block.
  struct Seen {
    Block block;
    double common;
    Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMostParities> split;
  };
  const auto seen = [&](Block block, UnitError error) -> Seen {
    const UnitSplit s = split_errors(weights, unit_sigmas(units, triad, error));
    return {block, row.dot(s.common), row.transpose() * s.split};
  };
  const Seen all[] = {seen(bias, UnitError::kBias), seen(drift, UnitError::kDrift), seen(scale, UnitError::kScale)};
  const auto sum = [&](const Seen& s) {
    Vector3d out = s.common * value(s.block);
    for (int k = 0; k < parities; ++k) out += s.split(k) * value(parity_block(s.block, k));
    return out;
  };

  const Vector3d gain = (1 + value(scale).array()).inverse();
  const Vector3d signal = gain.cwiseProduct((gyro ? fix.rate : fix.force) - value(bias) - value(drift));
  const Vector3d difference = sum(all[2]);  // of the scales
  const Vector3d loss = -gain.cwiseProduct(difference);
  const Matrix3d by_offset = loss.asDiagonal(), by_scale = loss.cwiseProduct(signal).asDiagonal();

  Linearization lin;
  lin.observes = bias;
  lin.residual = measured->value - (sum(all[0]) + sum(all[1]) + difference.cwiseProduct(signal));
  const double density = parity_noise(noise);
  lin.covariance =
      measured->sigma.cwiseAbs2().cwiseMax(Vector3d::Constant(density * density / fix.duration)).asDiagonal();
  for (const Seen& s : all) {
    const bool scales = s.block == scale;
    const Matrix3d by = scales ? Matrix3d(signal.asDiagonal()) : Matrix3d(Matrix3d::Identity());
    lin.add(s.block, s.common * by + (scales ? by_scale : by_offset));
    for (int k = 0; k < parities; ++k) lin.add(parity_block(s.block, k), s.split(k) * by);
  }
  return lin;
}

}  // namespace piste
