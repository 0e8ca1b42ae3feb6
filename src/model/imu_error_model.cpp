#include "model/imu_error_model.h"

#include <Eigen/LU>

namespace piste {
namespace {

// A matrix of the elements of a block: each stands in the row of its input and the column of its signal.
void put(Matrix3d& M, const Estimate& x, Block block) {
  const auto value = additive(x, block);
  Eigen::Index k = 0;
  for (const auto& [input, signal] : elements_of(block)) M(input % 3, signal % 3) += value(k++);
}

// A diagonal stays one to the last digit.
Matrix3d inverse(const Matrix3d& response) {
  if (response.isDiagonal(0)) return response.diagonal().cwiseInverse().asDiagonal();
  return response.inverse();
}

}  // namespace

Matrix3d gyro_response(const Estimate& x) {
  Matrix3d M = Matrix3d::Identity();
  put(M, x, Block::kGyroScale);
  put(M, x, Block::kGyroCrossAxis);
  return M;
}

Matrix3d accel_response(const Estimate& x) {
  Matrix3d M = Matrix3d::Identity();
  put(M, x, Block::kAccelScale);
  put(M, x, Block::kAccelCrossAxis);
  return M;
}

Matrix3d g_sensitivity(const Estimate& x) {
  Matrix3d G = Matrix3d::Zero();
  put(G, x, Block::kGyroGSensitivity);
  return G;
}

void add_imu_errors(Linearization& lin, const Estimate& x, std::span<const MotionPart> parts) {
  using ByInput = Eigen::Matrix<double, 3, 6>;
  const Matrix3d gyro = inverse(gyro_response(x)), accel = inverse(accel_response(x)), G = g_sensitivity(x);
  std::array<Eigen::Matrix<double, 3, kLargestBlock>, kImuErrorBlocks.size()> sums;
  for (auto& sum : sums) sum.setZero();
  for (const MotionPart& part : parts) {
    ByInput by_input;
    by_input.leftCols<3>() = -part.by_rate * gyro;
    by_input.rightCols<3>() = -(part.by_force + by_input.leftCols<3>() * G) * accel;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const ImuErrorBlock& b = kImuErrorBlocks[i];
      for (int k = 0; k < b.size(); ++k) {
        const ImuErrorElement& e = b.elements[static_cast<std::size_t>(k)];
        sums[i].col(k) += signal(e.signal, part.motion.rate, part.motion.force) * by_input.col(e.input);
      }
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) lin.add(kImuErrorBlocks[i].block, sums[i], kImuErrorBlocks[i].size());
}

}  // namespace piste
