#include "piste/model/strapdown.h"

#include <Eigen/LU>
#include <cmath>

#include "model/imu_error_model.h"

namespace piste {
namespace {

bool touches(const ImuSample& earlier, const ImuSample& later) {
  const double hole = later.time - later.interval - earlier.time;
  return !earlier.gap && !later.gap && std::abs(hole) < 0.01 * later.interval;
}

}  // namespace

ImuStep make_step(const ImuSample* before, const ImuSample& now, const ImuSample* after) {
  ImuStep step{now.interval, now.dtheta, now.dvel, Vector3d::Zero(), Vector3d::Zero()};
  const auto slopes = [](const ImuSample& a, const ImuSample& b) {
    const double span = 0.5 * (a.interval + b.interval);
    return std::pair<Vector3d, Vector3d>((b.dtheta / b.interval - a.dtheta / a.interval) / span,
                                         (b.dvel / b.interval - a.dvel / a.interval) / span);
  };
  const bool left = before && touches(*before, now), right = after && touches(now, *after);
  if (left && right) {
    const auto l = slopes(*before, now), r = slopes(now, *after);
    // The slope of the parabola that has the three samples' means over their intervals, for any lengths.
    const double wl = now.interval + 2 * after->interval, wr = now.interval + 2 * before->interval;
    step.rate_slope = (wl * l.first + wr * r.first) / (wl + wr);
    step.force_slope = (wl * l.second + wr * r.second) / (wl + wr);
  } else if (left || right) {
    const auto s = left ? slopes(*before, now) : slopes(now, *after);
    step.rate_slope = s.first;
    step.force_slope = s.second;
  }
  return step;
}

Vector3d neighbour_rate(const ImuSample* before, const ImuSample& now, const ImuSample* after) {
  const bool left = before && touches(*before, now), right = after && touches(now, *after);
  Vector3d sum = Vector3d::Zero();
  if (left) sum += before->dtheta / before->interval;
  if (right) sum += after->dtheta / after->interval;
  return left && right ? Vector3d(0.5 * sum) : sum;
}

std::pair<ImuStep, ImuStep> split(const ImuStep& step, double tau) {
  const double lead = 0.5 * tau * (tau - step.dt);
  ImuStep a = step, b = step;
  a.dt = tau;
  a.dtheta = step.dtheta * (tau / step.dt) + lead * step.rate_slope;
  a.dvel = step.dvel * (tau / step.dt) + lead * step.force_slope;
  b.dt = step.dt - tau;
  b.dtheta = step.dtheta - a.dtheta;
  b.dvel = step.dvel - a.dvel;
  return {a, b};
}

Vector3d corrected_rate(const Vector3d& measured, const Vector3d& force, const Estimate& x) {
  return correct({1, measured, force, Vector3d::Zero(), Vector3d::Zero()}, x).dtheta;
}

ImuStep correct(const ImuStep& measured, const Estimate& x) {
  if (has_cross_axis(x)) {
    const Matrix3d gyro = gyro_response(x).inverse(), accel = accel_response(x).inverse(), G = g_sensitivity(x);
    const Vector3d dvel = accel * (measured.dvel - measured.dt * (x.accel_bias + x.accel_drift)),
                   force_slope = accel * measured.force_slope;
    return {measured.dt, gyro * (measured.dtheta - measured.dt * (x.gyro_bias + x.gyro_drift) - G * dvel), dvel,
            gyro * (measured.rate_slope - G * force_slope), force_slope};
  }
  const Vector3d gyro = (1 + x.gyro_scale.array()).inverse(), accel = (1 + x.accel_scale.array()).inverse();
  return {measured.dt, gyro.cwiseProduct(measured.dtheta - measured.dt * (x.gyro_bias + x.gyro_drift)),
          accel.cwiseProduct(measured.dvel - measured.dt * (x.accel_bias + x.accel_drift)),
          gyro.cwiseProduct(measured.rate_slope), accel.cwiseProduct(measured.force_slope)};
}

Vector3d coned_rotation(const ImuStep& s) { return s.dtheta + (s.dt * s.dt / 12) * s.dtheta.cross(s.rate_slope); }

Vector3d sculled_velocity(const ImuStep& s) {
  const Vector3d& a = s.dtheta;
  const Vector3d& u = s.dvel;
  const double a2 = a.squaredNorm();
  double k1 = 0.5 - a2 / 24 * (1 - a2 / 30), k2 = (1 - a2 / 20 * (1 - a2 / 42)) / 6;
  if (a2 > 1e-3) {
    const double angle = std::sqrt(a2);
    k1 = (1 - std::cos(angle)) / a2;
    k2 = (1 - std::sin(angle) / angle) / a2;
  }
  const Vector3d au = a.cross(u);
  // Terms of the slopes: with one cross product, and with two. Without the latter the velocity is accurate to third
  // order only.
  const Vector3d a_slope = a.cross(s.force_slope);
  const Vector3d sculling = a_slope + u.cross(s.rate_slope) + 0.5 * (a.cross(a_slope) - s.rate_slope.cross(au));
  return u + k1 * au + k2 * a.cross(au) + (s.dt * s.dt / 12) * sculling;
}

void mechanize(Estimate& x, const ImuStep& s, const Vector3d& earth_rate, const Gravity& gravity) {
  const double dt = s.dt;
  const Quaterniond earth = so3_exp(-dt * earth_rate);
  const Vector3d du = x.q_wb * sculled_velocity(s);
  const Vector3d turned = 0.5 * (du + earth * du);
  const Vector3d p_mid = x.p_wb + 0.5 * dt * x.v_wb;
  const Vector3d v_mid = x.v_wb + 0.5 * (turned + dt * gravity.at(p_mid));
  const Vector3d v_end = x.v_wb + turned + dt * (gravity.at(p_mid) - 2 * earth_rate.cross(v_mid));
  // The trapezoidal rule for the velocity leaves out dt³/12 of the jerk, R (slope + ω × f).
  const Vector3d jerk = x.q_wb * (s.force_slope + s.dtheta.cross(s.dvel) / (dt * dt));
  x.p_wb += 0.5 * dt * (x.v_wb + v_end) - (dt * dt * dt / 12) * jerk;
  x.v_wb = v_end;
  x.q_wb = (earth * x.q_wb * so3_exp(coned_rotation(s))).normalized();
}

}  // namespace piste
