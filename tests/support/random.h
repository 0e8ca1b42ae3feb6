#pragma once
/// Random values for tests: fixed seed, same values everywhere.

#include <cmath>
#include <cstdint>
#include <random>

#include "piste/core/estimate.h"

namespace piste::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double gaussian(double sigma = 1) {
    return sigma * std::sqrt(-2 * std::log(uniform())) * std::cos(6.283185307179586 * uniform());
  }
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }

  Vector3d vector(double sigma = 1) {
    const double x = gaussian(sigma), y = gaussian(sigma), z = gaussian(sigma);
    return {x, y, z};
  }

  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index cols) {
    return Eigen::MatrixXd::NullaryExpr(rows, cols, [this] { return gaussian(); });
  }

  /// Symmetric, positive definite, eigenvalues of order one.
  Eigen::MatrixXd covariance(Eigen::Index n) {
    const Eigen::MatrixXd A = matrix(n, n);
    const Eigen::MatrixXd P = A * A.transpose() / static_cast<double>(n) + 0.1 * Eigen::MatrixXd::Identity(n, n);
    return 0.5 * (P + P.transpose());
  }

  /// Any attitude.
  Quaterniond rotation() {
    const Vector3d v = vector();
    return Quaterniond(gaussian(), v.x(), v.y(), v.z()).normalized();
  }

  /// Any attitude and boresight, some 20 m/s, scales of a few per cent, cross-axis errors of some 30 ppm, no block at
  /// zero.
  Estimate estimate() {
    Estimate x;
    x.q_wb = rotation();
    x.v_wb = vector(20);
    x.p_wb = vector(30);
    x.gyro_bias = vector(0.01);
    x.accel_bias = vector(0.1);
    x.gyro_drift = vector(0.003);
    x.accel_drift = vector(0.03);
    x.gyro_scale = vector(0.03);
    x.accel_scale = vector(0.03);
    x.q_rb = rotation();
    x.lever_arm = vector(0.7);
    x.gnss_position_drift = vector(0.5);
    x.gnss_delay = 0.08 + 0.02 * uniform();
    x.attitude_drift = vector(0.05);
    x.boresight_drift = vector(0.05);
    x.velocity_delay = 0.1 + 0.02 * uniform();
    x.attitude_delay = 0.02 + 0.01 * uniform();
    // Computed from the values above, so that later random values of a test do not change.
    x.q_vb = x.q_rb.conjugate() * x.q_wb;
    x.vehicle_contact = 2 * x.gnss_position_drift;
    x.pitch_centre = x.lever_arm.x();
    x.dive = x.gyro_drift.y();
    x.spring_pitch = x.boresight_drift.z();
    x.side_slip = 3 * x.accel_drift.x();
    x.wheel_slip = 3 * x.accel_drift.y();
    x.cornering = x.gyro_drift.x();
    x.odometer_scale = x.gyro_scale.y();
    x.barometer_offset = 3 * x.lever_arm.z();
    // So small that Φ, in which products of these errors with others are left out, agrees with differences.
    x.gyro_cross_axis << 1e-3 * x.gyro_scale, -1e-3 * x.accel_scale;
    x.accel_cross_axis = 1e-3 * (x.gyro_scale + x.accel_scale);
    x.gyro_g_sensitivity << 1e-4 * x.accel_scale, 1e-4 * x.gyro_scale, -1e-4 * x.accel_scale;
    for (std::size_t i = 0; i < x.parity.size(); ++i) {
      const Vector3d* const kinds[] = {&x.gyro_bias,   &x.accel_bias, &x.gyro_drift,
                                       &x.accel_drift, &x.gyro_scale, &x.accel_scale};
      const double part = 0.5 + 0.1 * static_cast<double>(i);
      x.parity[i] = part * Vector3d(kinds[i % kImuErrors]->y(), kinds[i % kImuErrors]->z(), kinds[i % kImuErrors]->x());
    }
    for (std::size_t i = 0; i < x.receiver.size(); ++i) {
      x.receiver[i] = (0.5 + 0.2 * static_cast<double>(i)) * x.gnss_position_drift;
    }
    x.hard_iron = 10 * x.lever_arm;
    x.soft_iron_x = x.gyro_scale;
    x.soft_iron_y = x.accel_scale;
    x.soft_iron_z = x.gyro_scale.cross(x.accel_scale) + x.gyro_scale;
    x.magnetic_disturbance = 20 * x.attitude_drift;
    return x;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace piste::test
