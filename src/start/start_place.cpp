#include "start/start_place.h"

#include <algorithm>
#include <iterator>
#include <span>

#include "core/time_search.h"
#include "model/alignment.h"
#include "piste/core/error.h"
#include "piste/math/units.h"
#include "start/first_motion.h"
#include "start/start_rest.h"
#include "start/stretch.h"
#include "walker/own_times.h"

namespace piste {

Beginning beginning(const Log& log, const Receiver& receiver, const StartOptions& options) {
  double time = log.imu.front().time - log.imu.front().interval;
  std::optional<Rest> rest = rest_at(log, time, options);
  if (!rest && receiver.fixes.front().time > time) {
    time = receiver.fixes.front().time;  // the body already moves: the run begins at the first fix
    rest = rest_at(log, time, options);
  }
  return {time, rest};
}

Receiver first_receiver(const Log& log, const FilterOptions& options) {
  for (std::size_t i = 0; i < log.gnss.size(); ++i) {
    if (!log.gnss[i].empty()) return {at_own_times(log.gnss[i], options.gnss[i]), options.gnss[i]};
  }
  throw DataError("start", "no GNSS fix within the span of the IMU; check the clocks, the span and the outages");
}

Quaterniond carry_back(const Log& log, const Quaterniond& q_end, double begin, double end, const Vector3d& bias) {
  const Quaterniond earth = so3_exp((end - begin) * log.world.earth_rate());
  return (earth * q_end * turned(log, begin, end, bias).conjugate()).normalized();
}

Quaterniond levelled(const Quaterniond& q_nb, const Vector3d& down_b) {
  return (rotation_between(q_nb * down_b, Vector3d::UnitZ()) * q_nb).normalized();
}

namespace {

// The first fix at or after `time` that does not contradict the next two, or the last fix.
FixPlace fix_from(const Receiver& receiver, double time, double fastest) {
  const auto& fixes = receiver.fixes;
  auto fix = first_at_or_after(fixes, time);
  if (fix == fixes.end()) fix = std::prev(fix);
  return past_outliers(fixes, fix, fastest);
}

// The covariance in w of independent errors along the axes of the local level.
Matrix3d in_w(const Matrix3d& R_wn, const Vector3d& sigma) {
  return R_wn * sigma.cwiseAbs2().asDiagonal() * R_wn.transpose();
}

// The mean specific force of the samples, in the body axes at the beginning of the first.
Vector3d first_force(std::span<const ImuSample> samples, const Vector3d& bias) {
  Quaterniond C = Quaterniond::Identity();
  Vector3d sum = Vector3d::Zero();
  double length = 0;
  for (const ImuSample& s : samples) {
    const Quaterniond turn = so3_exp(0.5 * (s.dtheta - s.interval * bias));
    C = C * turn;
    sum += C * s.dvel;
    C = C * turn;
    length += s.interval;
  }
  return sum / length;
}

}  // namespace

Quaterniond local_level(const World& world, const Receiver& receiver, double time) {
  constexpr double kAnyBody = 1000;  // m/s
  return Quaterniond(world.rotation_wn(fix_from(receiver, time, kAnyBody)->position));
}

void place_at_rest(const World& world, Start& start, const Receiver& receiver, const StartOptions& options) {
  const auto fix = fix_from(receiver, start.time, options.swaying);
  start.x.lever_arm = receiver.options.lever_arm;
  start.x.p_wb = fix->position - start.x.q_wb * receiver.options.lever_arm;
  start.x.v_wb.setZero();
  const Vector3d sigma = (3 * fix->sigma_position).cwiseMax(options.least_position);
  start.covariance.topLeftCorner<6, 6>().setZero();
  start.covariance.topLeftCorner<3, 3>() = in_w(world.rotation_wn(fix->position), sigma);
  start.covariance.diagonal().segment<3>(3).setConstant(0.01);
}

Start start_on_the_move(const Log& log, const FilterOptions& options, const Receiver& receiver, double time,
                        double heading, double sigma) {
  const StartOptions& o = options.behaviour.start;
  const FirstMotion antenna = first_motion(log.world, receiver.fixes, receiver.options, time, o);
  const GyroBias bias = bias_before(log, options, time);
  const double length = std::max(o.force_time, 1.5 * log.imu.front().interval);  // of one sample at least
  const auto now = range(log.imu, time + kSameInstant, time + length);
  Start start;
  set_known(start.x, options);
  start.time = time;
  if (now.empty()) throw DataError("start", "no IMU sample follows the first fix");
  const Vector3d force = first_force(now, bias.value);
  const Vector3d pushed = antenna.acceleration - log.world.gravity(antenna.position).value;
  start.x.q_wb = Quaterniond(antenna.R_wn) * level(force, heading);
  start.x.q_wb = (rotation_between(start.x.q_wb * force, pushed) * start.x.q_wb).normalized();
  const Vector3d rate = now.front().dtheta / now.front().interval - bias.value;
  const Vector3d& lever_arm = receiver.options.lever_arm;
  start.x.lever_arm = lever_arm;
  start.x.p_wb = antenna.position - start.x.q_wb * lever_arm;
  start.x.v_wb = antenna.velocity - start.x.q_wb * rate.cross(lever_arm);

  start.covariance.setZero();
  const Vector3d position = (o.loose * antenna.sigma(0)).cwiseMax(o.least_position);
  const Vector3d velocity = (o.loose * antenna.sigma(1)).cwiseMax(o.least_velocity);
  const double tilt =
      std::min(std::hypot(o.tilt_sigma, 2 * antenna.sigma(2).head<2>().maxCoeff() / kStandardGravity), o.most_tilt);
  start.covariance.topLeftCorner<3, 3>() = in_w(antenna.R_wn, position);
  start.covariance.block<3, 3>(3, 3) = in_w(antenna.R_wn, velocity);
  set_attitude_sigma(log.world, start, {tilt, tilt, sigma});
  set_boresight(start, log, options);
  return start;
}

void set_attitude_sigma(const World& world, Start& start, const Vector3d& sigma) {
  const Eigen::Matrix<double, 9, 9> ordinary = ordinary_from_invariant(start.x);
  Eigen::Matrix<double, 9, 9> P = ordinary * start.covariance * ordinary.transpose();
  P.bottomRows<3>().setZero();
  P.rightCols<3>().setZero();
  P.bottomRightCorner<3, 3>() = in_w(world.rotation_wn(start.x.p_wb), sigma);
  Eigen::Matrix<double, 9, 9> invariant = Eigen::Matrix<double, 9, 9>::Identity();
  invariant.block<3, 3>(3, 6) = skew(start.x.v_wb);  // ν = δv + v × θ
  start.covariance = invariant * P * invariant.transpose();
}

Vector3d attitude_sigma(const World& world, const Start& start) {
  const Matrix3d R_nw = world.rotation_wn(start.x.p_wb).transpose();
  return (R_nw * start.covariance.block<3, 3>(6, 6) * R_nw.transpose()).diagonal().cwiseSqrt();
}

void set_boresight(Start& start, const Log& log, const FilterOptions& options) {
  if (!options.estimates(Block::kBoresight)) return;
  for (std::size_t i = 0; i < log.attitude.size(); ++i) {
    const std::vector<AttitudeFix> fixes = at_own_times(log.attitude[i], options.attitude[i]);
    const auto fix = first_at_or_after(fixes, start.time);
    if (fix == fixes.end()) continue;
    const Quaterniond q_wb =
        start.x.q_wb * turned(log, start.time, fix->time, bias_before(log, options, fix->time).value);
    start.x.q_rb = (fix->q_wr.conjugate() * q_wb).normalized();
    return;
  }
}

}  // namespace piste
