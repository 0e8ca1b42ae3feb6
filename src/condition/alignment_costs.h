#pragma once
/// Cost functions of the least-squares problem of an alignment: residuals and Jacobians, in the form of Ceres.

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <type_traits>
#include <utility>

#include "paired_signals.h"
#include "rotation_manifold.h"

namespace piste {

using RowMatrix32 = Eigen::Matrix<double, 3, 2, Eigen::RowMajor>;
using RowMatrix33 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMatrix34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

/// One triad at one sample: measured = (1 + scale) R_rbᵀ (s(t) + L(t) p) + gain (bias + drift), with L = 0 for rates.
struct TriadSample {
  double sample_time, since_first;  ///< on the clock of the body IMU
  Vector3d measured;
  double gain, part;  ///< of the filters for a constant; place between two knots, 0 to 1
  Vector3d weight;    ///< 0 for an axis that is not usable
  const ReferenceGrid* reference;
};

/// Parameter blocks: clock, boresight, lever arm (of an accelerometer), bias, scale, drift at two knots.
template <bool kAccel>
using TriadBase = std::conditional_t<kAccel, ceres::SizedCostFunction<3, 2, 4, 3, 3, 3, 3, 3>,
                                     ceres::SizedCostFunction<3, 2, 4, 3, 3, 3, 3>>;

template <bool kAccel>
class TriadCost final : public TriadBase<kAccel> {
 public:
  explicit TriadCost(TriadSample triad) : t_(std::move(triad)) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    using Map3 = Eigen::Map<const Vector3d>;
    constexpr int kLever = 2, kBias = kAccel ? 3 : 2, kScale = kBias + 1, kBefore = kBias + 2, kAfter = kBias + 3;
    const double offset = parameters[0][0], drift = parameters[0][1];
    const Eigen::Map<const Quaterniond> q_rb(parameters[1]);
    const Map3 bias(parameters[kBias]), scale(parameters[kScale]), before(parameters[kBefore]),
        after(parameters[kAfter]);

    const ReferenceGrid::Value value = t_.reference->at(t_.sample_time - offset - drift * t_.since_first);
    Vector3d signal = value.signal.gyro, slope = value.slope.gyro;
    Matrix3d lever = Matrix3d::Zero();
    if constexpr (kAccel) {
      const Map3 p(parameters[kLever]);
      lever = value.signal.lever;
      signal = value.signal.accel + lever * p;
      slope = value.slope.accel + value.slope.lever * p;
    }
    const Matrix3d R_br = q_rb.toRotationMatrix().transpose();
    const Vector3d turned = R_br * signal, factor = Vector3d::Ones() + scale;
    const Vector3d predicted =
        factor.cwiseProduct(turned) + t_.gain * (bias + (1 - t_.part) * before + t_.part * after);
    Eigen::Map<Vector3d>{residuals} = t_.weight.cwiseProduct(t_.measured - predicted);
    if (!jacobians) return true;

    const Eigen::DiagonalMatrix<double, 3> minus_weight((-t_.weight).eval());
    const Matrix3d scaled = t_.weight.cwiseProduct(factor).asDiagonal() * R_br;  // of −d residual / d signal
    if (jacobians[0]) {
      const Vector3d by_time = scaled * slope;
      Eigen::Map<RowMatrix32> J(jacobians[0]);
      J.col(0) = by_time;
      J.col(1) = t_.since_first * by_time;
    }
    if (jacobians[1]) {
      Eigen::Map<RowMatrix34>{jacobians[1]} = -scaled * skew(signal) * RotationManifold::minus_jacobian(q_rb);
    }
    if constexpr (kAccel) {
      if (jacobians[kLever]) Eigen::Map<RowMatrix33>{jacobians[kLever]} = -scaled * lever;
    }
    const auto diagonal = [&](int block, double factor_of_gain) {
      if (jacobians[block]) Eigen::Map<RowMatrix33>{jacobians[block]} = Matrix3d(minus_weight) * factor_of_gain;
    };
    diagonal(kBias, t_.gain);
    diagonal(kBefore, t_.gain * (1 - t_.part));
    diagonal(kAfter, t_.gain * t_.part);
    if (jacobians[kScale]) Eigen::Map<RowMatrix33>{jacobians[kScale]} = Matrix3d(minus_weight) * turned.asDiagonal();
    return true;
  }

 private:
  TriadSample t_;
};

/// (value − factor · before) / sigma: the step of a drift from one knot to the next.
class StepCost final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  StepCost(double factor, double sigma) : factor_(factor), sigma_(sigma) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Vector3d> before(parameters[0]), after(parameters[1]);
    Eigen::Map<Vector3d>{residuals} = (after - factor_ * before) / sigma_;
    if (jacobians && jacobians[0])
      Eigen::Map<RowMatrix33>{jacobians[0]} = RowMatrix33::Identity() * (-factor_ / sigma_);
    if (jacobians && jacobians[1]) Eigen::Map<RowMatrix33>{jacobians[1]} = RowMatrix33::Identity() / sigma_;
    return true;
  }

 private:
  double factor_, sigma_;
};

/// value / sigma: the prior of a value about zero.
class PriorCost final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit PriorCost(double sigma) : sigma_(sigma) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Vector3d>{residuals} = Eigen::Map<const Vector3d>(parameters[0]) / sigma_;
    if (jacobians && jacobians[0]) Eigen::Map<RowMatrix33>{jacobians[0]} = RowMatrix33::Identity() / sigma_;
    return true;
  }

 private:
  double sigma_;
};

}  // namespace piste
