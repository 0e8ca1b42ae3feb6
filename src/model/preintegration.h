#pragma once
/// The samples of an IMU between two nodes of a batch, summed once.
///
/// In w, with v̄ = v + ω_ie × p and a gravitation that is constant over the interval, attitude, velocity and position
/// are one group. The samples form a factor in it that does not depend on the initial state (Brossard, Barrau, Chauchat
/// and Bonnabel 2021, "Associating uncertainty to extended poses for on Lie group IMU preintegration with rotating
/// Earth"):
///
///     R_j = Eᵀ R_i ΔR      E v̄_j = v̄_i + T J_l(T ω_ie) G_v + R_i ΔV      E p_j = p_i + T v̄_i + T² Γ G_p + R_i ΔP
///
/// with E = Exp(T ω_ie), Γ = Σ [T ω_ie]ⁿ / (n+2)! and G = g + ω_ie × (ω_ie × p). No term of the rotating Earth is left
/// out. Gravity is taken at the mean positions of the body, predicted from the initial velocity.
///
/// ΔR, ΔV, ΔP come from the steps of strapdown.h, with coning and sculling. Their noise is that of the sensors, jointly
/// with that of the drifts, which change within the interval too.

#include <array>
#include <utility>

#include "model/dynamics.h"
#include "model/imu_error_model.h"
#include "piste/model/measurement.h"

namespace piste {

/// Errors of an IMU: the elements of kImuErrorBlocks.
using ImuErrorVector = Eigen::Matrix<double, kImuErrorSize, 1>;

/// The preintegrated motion of an interval. ΔP and ΔV are in the body axes at the start of the interval.
struct SummedMotion {
  double time = 0;                             ///< length T
  Quaterniond turn = Quaterniond::Identity();  ///< ΔR
  Vector3d velocity = Vector3d::Zero(), position = Vector3d::Zero();
};

/// The same, with its covariance. Errors of (ΔP, ΔV, ΔR) have that order; that of ΔR is a rotation vector on its right:
/// truth = ΔR Exp(error).
struct ImuSum : SummedMotion {
  /// A column for each element of kImuErrorBlocks, in this order.
  using ByImu = Eigen::Matrix<double, 9, kImuErrorSize>;
  using Noise = Eigen::Matrix<double, 15, 15>;

  ByImu by_imu = ByImu::Zero();  ///< derivative by the estimated errors of the IMU, drifts as at the start
  Noise noise = Noise::Zero();   ///< covariance of (ΔP, ΔV, ΔR, gyro_drift, accel_drift) that the interval adds
};

/// Changes of the drifts over one step.
struct DriftStep {
  double decay = 1;                      ///< of the value
  Vector3d variance = Vector3d::Zero();  ///< that is added
};

/// Transition of the error of a sum over one step: by itself, and by errors of the estimated rate and specific force
/// (rad/s, m/s²), constant over the step. A greater bias makes a smaller sum.
struct SumStep {
  Matrix9d by_sum;
  Matrix96d by_reading;
};

/// Sums the steps of an interval.
class Preintegration {
 public:
  /// Columns: (ΔP, ΔV, ΔR, gyro_drift, accel_drift), the latter also as what drives the step. Rows, up to a multiple of
  /// four: the same fifteen for the covariance; from kDerivatives on the errors of the IMU, for the derivatives.
  static constexpr int kDerivatives = 16, kRows = (kDerivatives + kImuErrorSize + 3) / 4 * 4;
  using Carried = std::array<std::array<double, kRows>, 15>;

  /// `x`: the estimate at the start of the interval. Its errors of the IMU are taken out of every step.
  explicit Preintegration(Estimate x) : x_(std::move(x)) {}

  /// Adds a step, as measured. `reference`: the motion that the scales multiply, such as of a smoothed trajectory. The
  /// motion of the step itself has the noise of the residual, which would pass for a scale (errors in variables;
  /// reference.h). No heap.
  SumStep add(const ImuStep& measured, const StepNoise& noise, const BodyMotion& reference, const DriftStep& gyro,
              const DriftStep& accel);
  /// Adds a step to the motion alone. No heap.
  SumStep move(const ImuStep& measured, const DriftStep& gyro, const DriftStep& accel);

  const SummedMotion& motion() const { return motion_; }
  ImuSum sum() const;

 private:
  Estimate x_;                             // with its drifts after their decay
  double gyro_left_ = 1, accel_left_ = 1;  // remaining fraction of the drifts at the start
  SummedMotion motion_;
  alignas(32) Carried carried_{};
};

/// Propagates the derivatives by what the signals multiply (scales and cross-axis errors) over a step, as
/// Preintegration::add does.
void add_to_scales(ImuSum::ByImu& by_imu, const SumStep& step, const BodyMotion& reference);

/// The increment of the covariance of (ΔP, ΔV, ΔR) by the white noise of a step, times a vector.
Eigen::Matrix<double, 9, 1> white_noise_of(const SumStep& step, const StepNoise& noise, double dt,
                                           const Eigen::Matrix<double, 9, 1>& vector);

/// Two ends of an interval compared with the preintegrated samples, for the errors of estimate.h: residual = X_i⁻¹ X_j
/// ⊟ sum, in the order of ImuSum, and its derivatives by (ρ, ν, θ) at both ends. The derivatives are exact at any
/// residual, except for the curvature of gravity.
struct SumResidual {
  Eigen::Matrix<double, 9, 1> value;
  Matrix9d by_start, by_end;
  ImuSum::ByImu by_imu;  ///< by the errors of the IMU
};

/// `change`: difference of the errors of the IMU from those of the sum, in the order of its columns. `gravity`: near
/// the start.
SumResidual compare(const ImuSum& sum, const ImuErrorVector& change, const Estimate& start, const Estimate& end,
                    const Vector3d& earth_rate, const Gravity& gravity);

/// The residual alone, of a sum that was made with the errors of the IMU at `start`.
Eigen::Matrix<double, 9, 1> residual_of(const SummedMotion& sum, const Estimate& start, const Estimate& end,
                                        const Vector3d& earth_rate, const Gravity& gravity);

/// The same comparison, solved for the error of the end: (ρ, ν, θ) there = by_start (ρ, ν, θ) at the start + by_imu
/// times the errors of the IMU + shift + noise. The noise is that of the sum after turn_to_end().
struct SumTie {
  Eigen::Matrix<double, 9, 1> value;  ///< the residual of compare()
  Matrix9d by_start;
  ImuSum::ByImu by_imu;
  Eigen::Matrix<double, 9, 1> shift;

  Matrix3d place, turn, velocity, rate;  ///< parts of SumResidual::by_end⁻¹

  /// Multiplies a column of nine by SumResidual::by_end⁻¹.
  void turn_to_end(double* column) const {
    Eigen::Map<Vector3d> p(column), v(column + 3), theta(column + 6);
    p = (place * p).eval();
    theta = (turn * theta).eval();
    v = (place * v + velocity * theta - rate * p).eval();
  }
};

/// compare(), solved for the end block by block: no inverse of a whole matrix. SI, the world frame; the same arguments.
SumTie tie_ends(const ImuSum& sum, const ImuErrorVector& change, const Estimate& start, const Estimate& end,
                const Vector3d& earth_rate, const Gravity& gravity);

/// Attitude, velocity and position at the end for which compare() gives `residual`, without a change of the errors of
/// the IMU. The other blocks are those of `start`.
Estimate carry(const SummedMotion& sum, const Eigen::Matrix<double, 9, 1>& residual, const Estimate& start,
               const Vector3d& earth_rate, const Gravity& gravity);

}  // namespace piste
