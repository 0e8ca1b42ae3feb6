#include "piste/model/rest.h"

#include <algorithm>

#include "model/imu_error_model.h"

namespace piste {

Linearization linearize_zero_velocity(const RestOptions& rest, const Estimate& x) {
  Linearization lin;
  lin.observes = Block::kVelocity;
  lin.residual = -x.v_wb;
  lin.covariance = rest.sigma_velocity * rest.sigma_velocity * Matrix3d::Identity();
  lin.add(Block::kVelocity, Matrix3d::Identity());
  return lin;
}

Linearization linearize_zero_rate(const RestOptions& rest, const Vector3d& mean_gyro, double duration, double noise,
                                  const Estimate& x, const Vector3d& earth_rate, const Vector3d& gravity) {
  const Matrix3d R_bw = x.R_wb().transpose(), response = gyro_response(x), G = g_sensitivity(x);
  const Vector3d earth_b = R_bw * earth_rate, force = -R_bw * gravity;
  Linearization lin;
  lin.observes = Block::kGyroBias;
  lin.residual = mean_gyro - (response * earth_b + x.gyro_bias + x.gyro_drift + G * force);
  // The rate of the sway hardly changes from one mean to the next. It is modelled as white noise with the same integral
  // over time.
  const double alike = std::max(1.0, rest.correlation_time / duration);
  lin.covariance = (rest.sigma_rate * rest.sigma_rate * alike + noise * noise / duration) * Matrix3d::Identity();
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    if (b.elements[0].input >= 3) continue;
    Eigen::Matrix<double, 3, kLargestBlock> J = Eigen::Matrix<double, 3, kLargestBlock>::Zero();
    for (int k = 0; k < b.size(); ++k) {
      const ImuErrorElement& e = b.elements[static_cast<std::size_t>(k)];
      J(e.input, k) = signal(e.signal, earth_b, force);
    }
    lin.add(b.block, J, b.size());
  }
  lin.add(Block::kAttitude, response * R_bw * skew(earth_rate) - G * R_bw * skew(gravity));
  return lin;
}

std::optional<Linearization> ZeroUpdates::linearize(const RestFix& fix, int, int channel,
                                                    const MeasurementContext& context, const Estimate& x) {
  const FilterOptions& o = context.options;
  if (channel == 0) return linearize_zero_velocity(o.behaviour.rest, x);
  return linearize_zero_rate(o.behaviour.rest, fix.mean_gyro, fix.duration, o.sensor.gyro.noise, x, context.earth_rate,
                             context.gravity.value);
}

}  // namespace piste
