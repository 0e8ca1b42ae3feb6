#pragma once
/// The errors of an IMU, and how they act on its signals: the one table that mechanization, filter, smoother, batch and
/// measurements read.
///
///     ω_m = (1 + S_g + M_g) ω + b_g + d_g + G f + noise      f_m = (1 + S_a + M_a) f + b_a + d_a + noise
///
/// S is diagonal (scales). M_g has the six off-diagonal elements. The accelerometers define the axes of the
/// body, x along the first and y in the plane of the first two: so M_a is lower triangular, with three elements. G is
/// the g-sensitivity of gyroscopes. Source: Groves 2013, sections 4.4.2 and 4.4.4.
///
/// To first order an error of these parameters is an error of the inputs, e_g = δb + δd + δS ω + δM ω + δG f, and e_a
/// likewise: each element acts on one input in proportion to one signal.

#include <array>
#include <span>

#include "piste/model/measurement.h"

namespace piste {

/// Signals that errors are multiplied by: ω x y z, f x y z, and 1.
inline constexpr int kForceSignal = 3, kUnitSignal = 6, kSignalCount = 7;

/// An element of an error: it adds to the input (e_g 0 to 2, e_a 3 to 5) its value times the signal.
struct ImuErrorElement {
  int input, signal;
};

/// The errors of an IMU as inputs: for each block its elements.
struct ImuErrorBlock {
  Block block;
  std::array<ImuErrorElement, kLargestBlock> elements;
  constexpr int size() const { return info(block).size; }
};

/// In the order of the state table.
inline constexpr std::array kImuErrorBlocks = std::to_array<ImuErrorBlock>({
    {Block::kGyroBias, {{{0, 6}, {1, 6}, {2, 6}}}},
    {Block::kAccelBias, {{{3, 6}, {4, 6}, {5, 6}}}},
    {Block::kGyroDrift, {{{0, 6}, {1, 6}, {2, 6}}}},
    {Block::kAccelDrift, {{{3, 6}, {4, 6}, {5, 6}}}},
    {Block::kGyroScale, {{{0, 0}, {1, 1}, {2, 2}}}},
    {Block::kAccelScale, {{{3, 3}, {4, 4}, {5, 5}}}},
    {Block::kGyroCrossAxis, {{{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}}}},
    {Block::kAccelCrossAxis, {{{4, 3}, {5, 3}, {5, 4}}}},
    {Block::kGyroGSensitivity, {{{0, 3}, {0, 4}, {0, 5}, {1, 3}, {1, 4}, {1, 5}, {2, 3}, {2, 4}, {2, 5}}}},
});

/// The elements of one of these blocks.
constexpr std::span<const ImuErrorElement> elements_of(Block block) {
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    if (b.block == block) return std::span(b.elements).first(static_cast<std::size_t>(b.size()));
  }
  return {};
}

/// Elements of all these blocks together.
inline constexpr int kImuErrorSize = [] {
  int size = 0;
  for (const ImuErrorBlock& b : kImuErrorBlocks) size += b.size();
  return size;
}();

/// Elements that no signal multiplies: the first of the table.
inline constexpr int kConstantErrors = 12;

/// The signal with this number. Example: signal(4, ω, f) is the second component of f.
inline double signal(int number, const Vector3d& rate, const Vector3d& force) {
  return number == kUnitSignal ? 1 : number >= kForceSignal ? force(number - kForceSignal) : rate(number);
}

/// Whether an estimate has errors beyond biases, drifts and scales.
inline bool has_cross_axis(const Estimate& x) {
  return !x.gyro_cross_axis.isZero(0) || !x.accel_cross_axis.isZero(0) || !x.gyro_g_sensitivity.isZero(0);
}

/// 1 + S + M of the gyroscopes and of the accelerometers, and G. SI. Example: with a scale of 1000 ppm and an error xy
/// of 500 ppm, the first row of gyro_response() is 1.001, 0.0005, 0.
Matrix3d gyro_response(const Estimate& x);
Matrix3d accel_response(const Estimate& x);
Matrix3d g_sensitivity(const Estimate& x);

/// A motion on which a measurement depends, with its derivatives by ω and by f there.
struct MotionPart {
  Matrix3d by_rate, by_force;
  BodyMotion motion;  ///< the signals that the errors multiply
};

/// Adds the derivatives of a measurement by the errors of the IMU, as δω = −(1 + S + M)⁻¹ (e_g + G δf) and
/// δf = −(1 + S + M)⁻¹ e_a.
void add_imu_errors(Linearization& lin, const Estimate& x, std::span<const MotionPart> parts);

}  // namespace piste
