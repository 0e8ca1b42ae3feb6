#include "piste/model/attitude.h"

#include <algorithm>
#include <cmath>

#include "model/imu_error_model.h"
#include "model/recent_steps.h"

namespace piste {

namespace {

Quaterniond boresight_of(const Estimate& x) { return so3_exp(x.boresight_drift) * x.q_rb; }

// The measured reference axes without their white error; `drift`: the coloured error, in w.
Quaterniond reference_of(const Estimate& x, const Vector3d& drift, const Turning& turning) {
  const double tau = turning.lag.time;
  const Quaterniond q_wb = so3_exp(tau * turning.earth_rate) * x.q_wb * so3_exp(-tau * turning.rate);
  return so3_exp(drift) * q_wb * boresight_of(x).conjugate();
}

// The terms of the lag: of the delay, and of the gyroscopes' errors, which turn the attitude back by the wrong angle.
// `A`: the Jacobian of a rotation of R_wb from the left.
void add_lag(Linearization& lin, const Matrix3d& A, const Estimate& x, const Turning& turning) {
  const double tau = turning.lag.time;
  const Matrix3d R_wb = (so3_exp(tau * turning.earth_rate) * x.q_wb).toRotationMatrix();
  if (tau != 0) {
    // δω turns the body by −τ J_l(−ω τ) δω.
    const Matrix3d by_rate = -tau * A * R_wb * so3_left_jacobian(-tau * turning.rate);
    const MotionPart part{by_rate, Matrix3d::Zero(), {.rate = turning.rate, .force = turning.force}};
    add_imu_errors(lin, x, {&part, 1});
  }
  if (!turning.lag.is_uncertain()) return;
  // For a vibration at Ω = |ω'| / |ω| and a delay with 1-sigma σ, the derivative by the delay is reduced by the factor
  // exp(−Ω² σ² / 2) (statistical linearization; Gelb 1974, section 6.2).
  const double rate = std::max(turning.rate.squaredNorm() + turning.rate_variance, 1e-12);
  const double change = turning.rate_change.squaredNorm(), P = turning.lag.variance;
  const double weight = std::exp(-0.5 * P * change / rate);
  add_delay(lin, turning.lag,
            A * (turning.earth_rate - weight * R_wb * beyond_noise(turning.rate, turning.rate_variance)));
  add_curvature(lin, turning.lag, A * R_wb * turning.rate_change);
  // The term of third order has an unknown direction and a variance of 5/12 P³ |ω'|⁴ / |ω|². It is correlated from fix
  // to fix: ten times the variance is used, by Monte Carlo (LateSources in tests/scenario/delays.cpp).
  const double third = 5.0 / 12 * P * P * P * change * change / rate;
  lin.covariance += 10 * third * Matrix3d::Identity();
}

}  // namespace

Linearization linearize_attitude(const AttitudeFix& fix, const Vector3d& white, const Estimate& x, const Matrix3d& R_wn,
                                 const Estimate* after, const Turning& turning, const Turning& turning_after) {
  const Vector3d drift_w = R_wn * x.attitude_drift;
  const Quaterniond predicted = reference_of(x, drift_w, turning);
  Linearization lin;
  lin.observes = Block::kAttitude;
  lin.residual = so3_log(fix.q_wr * predicted.conjugate());
  const Matrix3d noise = so3_left_jacobian_inverse(lin.residual) * R_wn * white.asDiagonal() * R_wn.transpose();
  lin.covariance = noise * fix.covariance * noise.transpose();

  Matrix3d J = so3_left_jacobian_inverse(-lin.residual), R_wr = J * predicted.toRotationMatrix();
  if (after != nullptr) {
    const Vector3d turn =
        so3_log(reference_of(*after, R_wn * after->attitude_drift, turning_after) * predicted.conjugate());
    J.setIdentity();
    R_wr = (so3_exp(0.5 * turn) * predicted).toRotationMatrix();
  }
  const Matrix3d drift = so3_exp(drift_w).toRotationMatrix();
  lin.add(Block::kAttitude, J * drift * so3_exp(turning.lag.time * turning.earth_rate).toRotationMatrix());
  lin.add(Block::kBoresight, -R_wr * so3_exp(x.boresight_drift).toRotationMatrix());
  lin.add(Block::kAttitudeDrift, J * so3_left_jacobian(drift_w) * R_wn);
  lin.add(Block::kBoresightDrift, -R_wr * so3_left_jacobian(x.boresight_drift));
  add_lag(lin, J * drift, x, turning);
  return lin;
}

FixDelay ReferenceAttitudes::delay(const FilterOptions& options, const StateLayout& layout, int sensor, int,
                                   const Estimate& x, double elapsed) {
  FixDelay delay{.value = options.attitude[static_cast<std::size_t>(sensor)].delay};
  if (layout.has(Block::kAttitudeDelay)) {
    delay.value += x.attitude_delay - options.attitude.front().delay;
    delay.block = Block::kAttitudeDelay;
  }
  return with_clock_drift(delay, layout, x, elapsed);
}

std::optional<Linearization> ReferenceAttitudes::linearize(const AttitudeFix& fix, int sensor, int channel,
                                                           const MeasurementContext& context, const Estimate& x,
                                                           const Estimate* after) {
  const AttitudeOptions& reference = context.options.attitude[static_cast<std::size_t>(sensor)];
  const auto turning = [&](const Estimate& y) {
    const BodyMotion motion = context.motion(y);
    Turning t{.earth_rate = context.earth_rate,
              .rate = motion.rate,
              .lag = context.lag(delay(context.options, context.layout, sensor, channel, y, context.elapsed)),
              .rate_change = context.step.rate_slope,
              .rate_variance = motion.rate_variance.mean(),
              .force = motion.force};
    if (context.still) t.lag = {.time = t.lag.time};
    if (t.lag.time > kMoment && context.steps != nullptr && !context.still) {
      if (const auto over = context.steps->over(t.lag.time, y)) t.rate = over->rate;
    }
    return t;
  };
  return linearize_attitude(fix, reference.drift ? reference.white : Vector3d::Ones(), x, context.gravity.R_wn, after,
                            turning(x), after ? turning(*after) : Turning{});
}

}  // namespace piste
