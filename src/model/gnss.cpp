#include "piste/model/gnss.h"

namespace piste {
namespace {

// The antenna in w: lever arm, velocity by rotation, velocity and acceleration.
struct Antenna {
  Vector3d arm, swing, velocity, acceleration;
  Matrix3d R_wb, rate_to_velocity;  // R [l], minus the derivative of the velocity by the corrected rate
};

Antenna antenna_of(const Estimate& x, const BodyMotion& m, const Vector3d& earth_rate, const Gravity& gravity) {
  Antenna a;
  a.R_wb = x.R_wb();
  a.arm = a.R_wb * x.lever_arm;
  a.swing = a.R_wb * m.rate.cross(x.lever_arm) - earth_rate.cross(a.arm);
  a.velocity = x.v_wb + a.swing;
  a.acceleration = a.R_wb * m.force + gravity.at(x.p_wb) - 2 * earth_rate.cross(x.v_wb);
  a.rate_to_velocity = a.R_wb * skew(x.lever_arm);
  return a;
}

// Adds `factor` times the derivative of the antenna's velocity by the attitude and by the gyroscopes' errors.
// `carried`: the part of the velocity that rotates with the attitude, v + R (ω × l).
void add_turning(Linearization& lin, double factor, const Matrix3d& extra_attitude, const Antenna& a, const Estimate& x,
                 const BodyMotion& m, const Vector3d& earth_rate, const Vector3d& carried) {
  // δv_a = ν + θ × (v + R(ω × l)) − ω_ie × (θ × R l) + R [l] (1+s)⁻¹ e_g, as δω = −(1+s)⁻¹ e_g.
  const Matrix3d attitude = -skew(carried) + skew(earth_rate) * skew(a.arm);
  const Matrix3d gyro = factor * a.rate_to_velocity * (1 + x.gyro_scale.array()).inverse().matrix().asDiagonal();
  lin.add(Block::kAttitude, factor * attitude + extra_attitude);
  lin.add(Block::kGyroBias, gyro);
  lin.add(Block::kGyroDrift, gyro);
  lin.add(Block::kGyroScale, gyro * m.rate.asDiagonal());
}

Matrix3d first_column(const Vector3d& v) {
  Matrix3d m = Matrix3d::Zero();
  m.col(0) = v;
  return m;
}

}  // namespace

Linearization linearize_position(const GnssFix& fix, const std::optional<GaussMarkov>& drift, const Estimate& x,
                                 const BodyMotion& motion, const Vector3d& earth_rate, const Gravity& gravity) {
  const Antenna a = antenna_of(x, motion, earth_rate, gravity);
  const double delay = x.gnss_delay;
  Linearization lin;
  lin.residual = fix.position - (x.p_wb + a.arm - delay * a.velocity);
  if (drift) lin.residual -= x.gnss_position_drift;
  Vector3d variance = fix.sigma_position.cwiseAbs2();
  if (drift) variance = (variance - drift->sigma.cwiseAbs2()).cwiseMax(0.01 * variance);
  lin.covariance = variance.asDiagonal();

  const Vector3d carried = a.velocity + earth_rate.cross(a.arm);
  add_turning(lin, -delay, -skew(a.arm), a, x, motion, earth_rate, carried);
  lin.add(Block::kPosition, Matrix3d::Identity());
  lin.add(Block::kVelocity, -delay * Matrix3d::Identity());
  lin.add(Block::kLeverArm, a.R_wb - delay * (a.R_wb * skew(motion.rate) - skew(earth_rate) * a.R_wb));
  if (drift) lin.add(Block::kGnssPositionDrift, Matrix3d::Identity());
  lin.add(Block::kGnssDelay, first_column(-a.velocity));
  return lin;
}

Linearization linearize_velocity(const GnssFix& fix, const Estimate& x, const BodyMotion& motion,
                                 const Vector3d& earth_rate, const Gravity& gravity, bool still) {
  const Antenna a = antenna_of(x, motion, earth_rate, gravity);
  const double delay = x.gnss_delay;
  Linearization lin;
  lin.observes = Block::kVelocity;
  lin.residual = fix.velocity->value - (a.velocity - delay * a.acceleration);
  if (!fix.velocity->has_down()) lin.rows = 2;
  lin.covariance.diagonal().head(lin.rows) = fix.velocity->sigma.head(lin.rows).cwiseAbs2();
  lin.covariance += a.rate_to_velocity * motion.rate_variance.asDiagonal() * a.rate_to_velocity.transpose();

  const Vector3d swing = a.swing + earth_rate.cross(a.arm);
  const Vector3d carried = still ? swing : (x.v_wb + swing).eval();
  // −τ δa = −τ (θ × R f − R (1+s)⁻¹ e_a + Γ ρ − 2 ω_ie × (ν + θ × v))
  const Matrix3d E = skew(earth_rate);
  const Matrix3d turn = delay * (skew(a.R_wb * motion.force) - 2 * E * skew(x.v_wb));
  const Matrix3d accel = delay * a.R_wb * (1 + x.accel_scale.array()).inverse().matrix().asDiagonal();
  // At rest the measured rate is noise, which the lever arm takes into the residual too: it must not look like an
  // effect of the scale.
  const BodyMotion turning{.rate = still ? Vector3d::Zero().eval() : motion.rate, .force = motion.force};
  add_turning(lin, 1, turn, a, x, turning, earth_rate, carried);
  lin.add(Block::kPosition, -delay * gravity.gradient);
  lin.add(Block::kVelocity, Matrix3d::Identity() + 2 * delay * E);
  lin.add(Block::kAccelBias, accel);
  lin.add(Block::kAccelDrift, accel);
  lin.add(Block::kAccelScale, accel * motion.force.asDiagonal());
  lin.add(Block::kLeverArm, a.R_wb * skew(motion.rate) - E * a.R_wb);
  lin.add(Block::kGnssDelay, first_column(-a.acceleration));
  return lin;
}

bool GnssReceivers::repeats(const GnssFix& fix, const GnssFix& before) {
  return before.position == fix.position && before.velocity.has_value() == fix.velocity.has_value() &&
         (!fix.velocity || before.velocity->value == fix.velocity->value);
}

std::optional<Linearization> GnssReceivers::linearize(const GnssFix& fix, int sensor, int channel,
                                                      const MeasurementContext& context, const Estimate& x) {
  const GnssOptions& receiver = context.options.gnss[static_cast<std::size_t>(sensor)];
  const bool position = channel == 0;
  if (position ? !receiver.use_position : !(receiver.use_velocity && fix.velocity)) return std::nullopt;
  Estimate with_arm = x;
  if (!context.layout.has(Block::kLeverArm)) with_arm.lever_arm = receiver.lever_arm;
  const BodyMotion motion = context.motion(x);
  if (position) return linearize_position(fix, receiver.drift, with_arm, motion, context.earth_rate, context.gravity);
  return linearize_velocity(fix, with_arm, motion, context.earth_rate, context.gravity, context.still);
}

}  // namespace piste
