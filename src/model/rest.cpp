#include "piste/model/rest.h"

#include <algorithm>

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
                                  const Estimate& x, const Vector3d& earth_rate) {
  const Matrix3d R_bw = x.R_wb().transpose();
  const Vector3d earth_b = R_bw * earth_rate;
  const Vector3d gain = Vector3d::Ones() + x.gyro_scale;
  Linearization lin;
  lin.observes = Block::kGyroBias;
  lin.residual = mean_gyro - (gain.cwiseProduct(earth_b) + x.gyro_bias + x.gyro_drift);
  // The rate of the sway hardly changes from one mean to the next. It is modelled as white noise with the same integral
  // over time.
  const double alike = std::max(1.0, rest.correlation_time / duration);
  lin.covariance = (rest.sigma_rate * rest.sigma_rate * alike + noise * noise / duration) * Matrix3d::Identity();
  lin.add(Block::kGyroBias, Matrix3d::Identity());
  lin.add(Block::kGyroDrift, Matrix3d::Identity());
  lin.add(Block::kGyroScale, earth_b.asDiagonal());
  lin.add(Block::kAttitude, gain.asDiagonal() * R_bw * skew(earth_rate));
  return lin;
}

std::optional<Linearization> ZeroUpdates::linearize(const RestFix& fix, int, int channel,
                                                    const MeasurementContext& context, const Estimate& x) {
  const FilterOptions& o = context.options;
  if (channel == 0) return linearize_zero_velocity(o.behaviour.rest, x);
  return linearize_zero_rate(o.behaviour.rest, fix.mean_gyro, fix.duration, o.sensor.gyro.noise, x, context.earth_rate);
}

}  // namespace piste
