#include "piste/model/gnss.h"

#include <cmath>

#include "model/gnss_white.h"
#include "model/imu_error_model.h"
#include "model/recent_steps.h"

namespace piste {
namespace {

// s: a velocity that is later than its position by this is taken for a mean over twice that time, in which a vibration
// is averaged out.
constexpr double kMean = 0.02;

// The common part of the two measurements: the lever arm, the acceleration of the IMU, and the derivatives of both by
// errors of the IMU.
struct Antenna {
  Matrix3d R_wb;
  Vector3d arm;            // R l
  Quaterniond back;        // C: turns b into its axes τ before
  Matrix3d back_jacobian;  // J_l(−ω̄ τ)
  Vector3d acceleration;   // a

  Antenna(const Estimate& x, const AntennaMotion& m, const Vector3d& earth_rate, const Gravity& gravity, double tau)
      : R_wb(x.R_wb()),
        arm(R_wb * x.lever_arm),
        back(so3_exp(-tau * m.over_lag().rate)),
        back_jacobian(so3_left_jacobian(-tau * m.over_lag().rate)),
        acceleration(R_wb * m.over_lag().force + gravity.at(x.p_wb) - 2 * earth_rate.cross(x.v_wb)) {}
};

// Derivatives of a by the blocks and by f̄, times `factor`: δa = θ × R f̄ + R δf̄ + Γ ρ − 2 ω_ie × (ν + θ × v).
struct AccelerationTerms {
  Matrix3d position, velocity, attitude, force;

  AccelerationTerms(double factor, const Antenna& a, const Estimate& x, const BodyMotion& mean,
                    const Vector3d& earth_rate, const Gravity& gravity)
      : position(factor * gravity.gradient),
        velocity(-2 * factor * skew(earth_rate)),
        attitude(-factor * (skew(a.R_wb * mean.force) - 2 * skew(earth_rate) * skew(x.v_wb))),
        force(factor * a.R_wb) {}
};

// The derivative of C u by ω̄: C u turns by J_l(−ω̄ τ) (−τ δω̄).
Matrix3d turning_back(const Vector3d& then, const Antenna& a, double tau) { return tau * skew(then) * a.back_jacobian; }

// The factor of the delay of an instantaneous velocity: the present force. A mean lags a vibration, all of which the
// velocity shows.
AntennaMotion of_the_moment(AntennaMotion motion, const MeasurementContext& context) {
  const double noise = context.options.sensor.accel.noise;
  motion.mean.force = motion.now.force;
  motion.force_change = context.step.force_slope + motion.now.rate.cross(motion.now.force);
  motion.force_variance = noise * noise / context.step.dt;
  return motion;
}

// Turns the rows from w to the local level, and leaves out down.
void keep_horizontal(Linearization& lin, const Matrix3d& R_wn) {
  lin.turn(R_wn.transpose());
  lin.rows = 2;
}

// The slow part of a total sigma, over its share of it: 1 where the white part is below its most.
Vector3d beyond_white(const Vector3d& total, const PositionDrift& drift) {
  const auto least = 1 - (drift.most_white / total.array()).square();
  return (least.max(drift.sigma.array().square()).sqrt() / drift.sigma.array()).matrix();
}

// A slow error in units of its state in m, along n.
Matrix3d slow_factor(const GnssFix& fix, const PositionDrift& drift) {
  const Vector3d level = fix.slow_level.cwiseProduct(fix.sigma_position);
  return fix.slow_level.cwiseProduct(beyond_white(level, drift)).asDiagonal() * fix.position_factor();
}

// Of an antenna that moves on the body, likewise: its displacement adds to the lever arm. Its speed is white noise of a
// velocity: the mean over the correlation time τ has a variance of 2 (1 − 1/e) σ²/τ².
Linearization swaying(Linearization lin, const GnssOptions& receiver, int sensor) {
  if (!receiver.lever_arm_sway) return lin;
  lin.add(lever_arm_sway_block(sensor), lin.jacobian(Block::kLeverArm));
  if (lin.observes != Block::kVelocity) return lin;
  const GaussMarkov& sway = *receiver.lever_arm_sway;
  const double mean = 2 * (1 - std::exp(-1.0));
  const double speed = sway.sigma.x() / sway.correlation_time;
  lin.covariance.topLeftCorner(lin.rows, lin.rows).diagonal().array() += mean * speed * speed;
  return lin;
}

}  // namespace

Matrix3d white_factor(const GnssFix& fix, const std::optional<PositionDrift>& drift) {
  if (!drift) return fix.position_factor();
  const auto rest = [](const Vector3d& share) { return (1 - share.array().square()).matrix().eval(); };
  if (drift->of_stated) {
    const Vector3d level = fix.slow_level.cwiseProduct(fix.sigma_position),
                   at_once = drift->sigma.cwiseProduct(beyond_white(fix.sigma_position, *drift)),
                   slow = drift->sigma.cwiseProduct(beyond_white(level, *drift));
    const Vector3d usual = rest(at_once), now = rest(slow.cwiseProduct(fix.slow_level));
    const Vector3d larger = now.cwiseQuotient(usual).cwiseMax(1).cwiseSqrt();
    return larger.asDiagonal() * fix.position_factor() * usual.cwiseSqrt().asDiagonal();
  }
  constexpr double kLeast = 0.01;  // of the variance: a drift in m may be as large as the sigma of a fix
  const Vector3d share = drift->sigma.cwiseQuotient(fix.sigma_position);
  return rest(share).cwiseMax(kLeast).cwiseSqrt().asDiagonal() * fix.position_factor();
}

Vector3d slow_error(const GnssFix& fix, const std::optional<PositionDrift>& drift, int receiver, const Estimate& x) {
  if (!drift) return Vector3d::Zero();
  const Vector3d state = additive(x, position_drift_block(receiver, drift->of_stated));
  return drift->of_stated ? slow_factor(fix, *drift) * state : state;
}

Linearization linearize_position(const GnssFix& fix, const std::optional<PositionDrift>& drift, const Estimate& x,
                                 const AntennaMotion& motion, const Vector3d& earth_rate, const Gravity& gravity,
                                 const Lag& lag, bool still, int receiver) {
  const double tau = lag.time, half = 0.5 * tau * tau;
  const Antenna a(x, motion, earth_rate, gravity, tau);
  const Vector3d arm_b = a.back * x.lever_arm;
  const Matrix3d ER = so3_exp(tau * earth_rate).toRotationMatrix() * a.R_wb;
  const Vector3d arm = ER * arm_b;
  Linearization lin;
  lin.residual = fix.position - (x.p_wb + arm - tau * x.v_wb + half * a.acceleration);
  lin.residual -= gravity.R_wn * slow_error(fix, drift, receiver, x);
  const Matrix3d white = gravity.R_wn * white_factor(fix, drift);
  lin.covariance = white * white.transpose();

  if (tau == 0) {
    lin.add(Block::kAttitude, -skew(arm));
    lin.add(Block::kPosition, Matrix3d::Identity());
  } else {
    const AccelerationTerms t(half, a, x, motion.over_lag(), earth_rate, gravity);
    const Matrix3d turned_arm = so3_exp(tau * earth_rate).toRotationMatrix() * skew(a.R_wb * arm_b);
    lin.add(Block::kAttitude, tau * skew(x.v_wb) + t.attitude - turned_arm);
    lin.add(Block::kPosition, Matrix3d::Identity() + t.position);
    lin.add(Block::kVelocity, -tau * Matrix3d::Identity() + t.velocity);
    const MotionPart lagged{ER * turning_back(arm_b, a, tau), t.force, motion.over_lag()};
    add_imu_errors(lin, x, {&lagged, 1});
  }
  lin.add(Block::kLeverArm, ER * a.back.toRotationMatrix());
  if (drift && drift->of_stated) {
    lin.add(position_drift_block(receiver, true), gravity.R_wn * slow_factor(fix, *drift));
  } else if (drift) {
    lin.add(position_drift_block(receiver, false), gravity.R_wn);
  }
  if (still) return lin;
  const Vector3d acceleration = a.acceleration + a.R_wb * (motion.mean.force - motion.over_lag().force);
  add_delay(lin, lag, tau * acceleration - x.v_wb + earth_rate.cross(arm) - ER * motion.mean.rate.cross(arm_b));
  add_curvature(lin, lag, acceleration);
  return lin;
}

Linearization linearize_velocity(const GnssFix& fix, const Estimate& x, const AntennaMotion& motion,
                                 const Vector3d& earth_rate, const Gravity& gravity, bool still, const Lag& lag) {
  const double tau = lag.time;
  const Antenna a(x, motion, earth_rate, gravity, tau);
  const Vector3d swing_b = a.back * motion.now.rate.cross(x.lever_arm);
  const Vector3d swing = a.R_wb * swing_b - earth_rate.cross(a.arm);
  const Matrix3d RC = a.R_wb * a.back.toRotationMatrix();
  const Matrix3d by_rate = -RC * skew(x.lever_arm);
  Linearization lin;
  lin.observes = Block::kVelocity;
  lin.residual = fix.velocity->value - (x.v_wb + swing - tau * a.acceleration);
  Vector3d variance = fix.velocity->sigma.cwiseAbs2();
  if (!fix.velocity->has_down()) variance.z() = 0;  // the row is left out below
  lin.covariance = gravity.R_wn * variance.asDiagonal() * gravity.R_wn.transpose();
  lin.covariance += by_rate * motion.now.rate_variance.asDiagonal() * by_rate.transpose();
  lin.by_rate_noise = by_rate;
  lin.observed_noise = motion.observed_noise;

  // An error of attitude turns v, and the part of the swing without the Earth's rotation. At rest both are noise, which
  // must give no information on the heading.
  const Vector3d turned = swing + earth_rate.cross(a.arm);
  const Vector3d carried = still ? Vector3d::Zero().eval() : (x.v_wb + turned).eval();
  const Matrix3d E = skew(earth_rate);
  const Vector3d& rate = motion.reference_rate;
  const Matrix3d attitude = -skew(carried) + E * skew(a.arm);
  const MotionPart now{by_rate, Matrix3d::Zero(), {.rate = rate, .force = motion.now.force}};
  if (tau == 0) {
    lin.add(Block::kAttitude, attitude);
    add_imu_errors(lin, x, {&now, 1});
    lin.add(Block::kVelocity, Matrix3d::Identity());
  } else {
    const AccelerationTerms t(-tau, a, x, motion.over_lag(), earth_rate, gravity);
    lin.add(Block::kAttitude, attitude + t.attitude);
    lin.add(Block::kPosition, t.position);
    lin.add(Block::kVelocity, Matrix3d::Identity() + t.velocity);
    const MotionPart parts[] = {now, {a.R_wb * turning_back(swing_b, a, tau), t.force, motion.over_lag()}};
    add_imu_errors(lin, x, parts);
    if (!motion.lagged) {
      const Vector3d jerk = a.R_wb * motion.force_change;
      lin.covariance += 0.25 * tau * tau * tau * tau * jerk * jerk.transpose();
    }
  }
  lin.add(Block::kLeverArm, RC * skew(rate) - E * a.R_wb);
  if (!still) {
    const Vector3d recent = a.acceleration + a.R_wb * (motion.mean.force - motion.over_lag().force);
    const Vector3d acceleration = beyond_noise(recent, motion.force_variance);
    add_delay(lin, lag, -acceleration - a.R_wb * motion.mean.rate.cross(swing_b));
    add_curvature(lin, lag, a.R_wb * motion.force_change);
  }
  if (!fix.velocity->has_down()) keep_horizontal(lin, gravity.R_wn);
  return lin;
}

namespace {

// Adds `factor` times the Jacobians of another measurement.
void add_terms(Linearization& lin, const Linearization& other, double factor) {
  for (int i = 0; i < other.count(); ++i) lin.accumulate(other.term(i), factor);
}

}  // namespace

Linearization linearize_mean_velocity(const GnssFix& fix, double averaging, const Estimate& x, const AntennaMotion& end,
                                      const AntennaMotion& begin, const Vector3d& earth_rate, const Gravity& gravity,
                                      bool still, const Lag& lag) {
  Lag before = lag;
  before.time += averaging;
  const Linearization last = linearize_position(fix, {}, x, end, earth_rate, gravity, lag, still),
                      first = linearize_position(fix, {}, x, begin, earth_rate, gravity, before, still);
  Linearization lin;
  lin.observes = Block::kVelocity;
  lin.residual = fix.velocity->value + (last.residual - first.residual) / averaging;
  Vector3d variance = fix.velocity->sigma.cwiseAbs2();
  if (!fix.velocity->has_down()) variance.z() = 0;  // the row is left out below
  lin.covariance = gravity.R_wn * variance.asDiagonal() * gravity.R_wn.transpose();
  add_terms(lin, last, 1 / averaging);
  add_terms(lin, first, -1 / averaging);
  if (!fix.velocity->has_down()) keep_horizontal(lin, gravity.R_wn);
  return lin;
}

bool GnssReceivers::repeats(const GnssFix& fix, const GnssFix& before) {
  return before.position == fix.position && before.velocity.has_value() == fix.velocity.has_value() &&
         (!fix.velocity || before.velocity->value == fix.velocity->value);
}

FixDelay GnssReceivers::delay(const FilterOptions& options, const StateLayout& layout, int sensor, int channel,
                              const Estimate& x, double elapsed) {
  const GnssOptions &receiver = options.gnss[static_cast<std::size_t>(sensor)], &first = options.gnss.front();
  const bool position = channel == 0;
  FixDelay delay{.value = position ? receiver.delay : receiver.delay_of_velocity()};
  if (!position && layout.has(Block::kVelocityDelay)) {
    delay.value += x.velocity_delay - first.delay_of_velocity();
    delay.block = Block::kVelocityDelay;
  } else if (layout.has(Block::kGnssDelay)) {
    delay.value += x.gnss_delay - first.delay;
    delay.block = Block::kGnssDelay;
  }
  if (!position) delay.value -= 0.5 * receiver.velocity_averaging;  // by the end of the mean
  return with_clock_drift(delay, layout, x, elapsed);
}

std::optional<Linearization> GnssReceivers::linearize(const GnssFix& fix, int sensor, int channel,
                                                      const MeasurementContext& context, const Estimate& x) {
  const GnssOptions& receiver = context.options.gnss[static_cast<std::size_t>(sensor)];
  const bool position = channel == 0;
  if (position ? !receiver.use_position : !(receiver.use_velocity && fix.velocity)) return std::nullopt;
  Estimate with_arm = x;
  if (!context.layout.has(Block::kLeverArm)) with_arm.lever_arm = receiver.lever_arm;
  if (receiver.lever_arm_sway) with_arm.lever_arm += additive(x, lever_arm_sway_block(sensor));
  AntennaMotion motion{context.motion(x),      context.rate_without_noise(x), context.observed_noise(),
                       context.mean_motion(x), context.recent.force_change,   context.recent.force_variance};
  const Lag lag = context.lag(delay(context.options, context.layout, sensor, channel, x, context.elapsed));
  if (lag.time > kMoment && context.steps != nullptr && !context.still) {
    if (const auto over = context.steps->over(lag.time, x)) {
      const bool of_place = position || receiver.velocity_averaging > 0;
      motion.lagged = BodyMotion{.rate = over->rate, .force = of_place ? over->position_force : over->velocity_force};
      motion.now.rate = motion.reference_rate = over->rate_then;
    }
  }
  if (position) {
    Linearization lin = linearize_position(fix, receiver.drift, with_arm, motion, context.earth_rate, context.gravity,
                                           lag, context.still, sensor);
    lin.excluded = fix.runs_away && receiver.use_velocity;  // velocities that are not used accuse nobody
    return swaying(std::move(lin), receiver, sensor);
  }
  if (const double averaging = receiver.velocity_averaging; averaging > 0 && !context.still) {
    AntennaMotion begin = motion;
    if (context.steps != nullptr) {
      if (const auto over = context.steps->over(std::max(lag.time, 0.0) + averaging, x)) {
        begin.lagged = BodyMotion{.rate = over->rate, .force = over->position_force};
      }
    }
    return swaying(linearize_mean_velocity(fix, averaging, with_arm, motion, begin, context.earth_rate, context.gravity,
                                           context.still, lag),
                   receiver, sensor);
  }
  const bool momentary =
      std::abs(lag.time) < kMoment && std::abs(receiver.delay_of_velocity() - receiver.delay) < kMean;
  return swaying(linearize_velocity(fix, with_arm, momentary ? of_the_moment(motion, context) : motion,
                                    context.earth_rate, context.gravity, context.still, lag),
                 receiver, sensor);
}

}  // namespace piste
