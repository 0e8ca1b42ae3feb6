#include "piste/model/preintegration.h"

namespace piste {
namespace {

constexpr int kPlace = 0, kSpeed = 3, kTurn = 6, kGyroDrift = 9, kAccelDrift = 12;

// Γ of the position: Σ [φ]ⁿ / (n+2)!. The angle is that of the Earth in seconds: two terms beyond the first are exact.
Matrix3d double_integral(const Vector3d& angle) {
  const Matrix3d S = skew(angle);
  return 0.5 * Matrix3d::Identity() + S / 6 + S * S / 24;
}

// What the rotating Earth and gravity do over an interval that begins at `start`.
struct Fall {
  Matrix3d E;                                     // Exp(T ω_ie)
  Vector3d velocity, position;                    // T J_l G_v, T² Γ G_p
  Matrix3d velocity_by_place, position_by_place;  // their derivatives by p; those by v have T/2 and T/3 before them
};

Fall fall_of(double T, const Estimate& start, const Vector3d& earth_rate, const Gravity& gravity) {
  const Vector3d angle = T * earth_rate;
  const Matrix3d omega = skew(earth_rate), by_place = gravity.gradient + omega * omega;
  const auto gravitation = [&](const Vector3d& p) { return Vector3d(gravity.at(p) + omega * (omega * p)); };
  const Matrix3d once = T * so3_left_jacobian(angle), twice = T * T * double_integral(angle);
  return {so3_exp(angle).toRotationMatrix(), once * gravitation(start.p_wb + T / 2 * start.v_wb),
          twice * gravitation(start.p_wb + T / 3 * start.v_wb), once * by_place, twice * by_place};
}

}  // namespace

SumStep Preintegration::add(const ImuStep& measured, const StepNoise& noise, const BodyMotion& told,
                            const DriftStep& gyro, const DriftStep& accel) {
  const ImuStep s = correct(measured, x_);
  const double dt = s.dt;
  const Vector3d turn = coned_rotation(s), du = sculled_velocity(s);
  const Quaterniond step_turn = so3_exp(turn);
  const Matrix3d R = sum_.turn.toRotationMatrix(), R_half = (sum_.turn * so3_exp(0.5 * turn)).toRotationMatrix();
  const Vector3d moved = 0.5 * dt * du - dt * dt * dt / 12 * (s.force_slope + s.dtheta.cross(s.dvel) / (dt * dt));

  SumStep step;
  Matrix9d& A = step.by_sum;
  A.setIdentity();
  A.block<3, 3>(kPlace, kSpeed).diagonal().setConstant(dt);
  A.block<3, 3>(kPlace, kTurn) = -R * skew(moved);
  A.block<3, 3>(kSpeed, kTurn) = -R * skew(du);
  A.block<3, 3>(kTurn, kTurn) = step_turn.toRotationMatrix().transpose();
  // true = (measured − bias − drift) / (1 + scale)
  const Matrix3d gyro_gain = (1 + x_.gyro_scale.array()).inverse().matrix().asDiagonal();
  const Matrix3d accel_gain = (1 + x_.accel_scale.array()).inverse().matrix().asDiagonal();
  const Matrix3d swing = 0.5 * dt * (R * skew(du)) * gyro_gain;
  Matrix96d& B = step.by_reading;
  B.setZero();
  B.block<3, 3>(kPlace, 0) = dt / 3 * swing;
  B.block<3, 3>(kSpeed, 0) = swing;
  B.block<3, 3>(kTurn, 0) = -dt * (so3_left_jacobian(-turn) * gyro_gain);
  B.block<3, 3>(kSpeed, 3) = -dt * (R_half * accel_gain);
  B.block<3, 3>(kPlace, 3) = 0.5 * dt * B.block<3, 3>(kSpeed, 3);

  // Covariance: of (sum, drifts) on itself, then the noise of the step.
  using Mixed = Eigen::Matrix<double, 9, 15>;
  ImuSum::Noise& P = sum_.noise;
  const Mixed after = A.lazyProduct(P.topRows<9>()) + B.lazyProduct(P.bottomRows<6>());
  P.topLeftCorner<9, 9>() =
      after.leftCols<9>().lazyProduct(A.transpose()) + after.rightCols<6>().lazyProduct(B.transpose());
  Eigen::Matrix<double, 6, 1> decay;
  decay << Vector3d::Constant(gyro.decay), Vector3d::Constant(accel.decay);
  P.topRightCorner<9, 6>() = after.rightCols<6>() * decay.asDiagonal();
  P.bottomLeftCorner<6, 9>() = P.topRightCorner<9, 6>().transpose();
  P.bottomRightCorner<6, 6>() = (decay.asDiagonal() * P.bottomRightCorner<6, 6>() * decay.asDiagonal()).eval();
  P.diagonal().segment<3>(kGyroDrift) += gyro.variance;
  P.diagonal().segment<3>(kAccelDrift) += accel.variance;
  Eigen::Matrix<double, 6, 1> white;
  white << noise.gyro / dt, noise.accel / dt;
  P.topLeftCorner<9, 9>() += (B * white.asDiagonal()).lazyProduct(B.transpose());
  // White noise within the step moves the place by dt³/3 of its density, of which the mean of the step tells dt³/4.
  const auto push = B.block<3, 3>(kSpeed, 3);
  P.topLeftCorner<3, 3>() += dt * dt / 12 * (push * white.tail<3>().asDiagonal() * push.transpose());
  P.topLeftCorner<9, 9>() = (0.5 * (P.topLeftCorner<9, 9>() + P.topLeftCorner<9, 9>().transpose())).eval();

  ImuSum::ByImu& J = sum_.by_imu;
  J = A.lazyProduct(J).eval();
  J.middleCols<6>(0) += B;
  // A drift at the start has become less by now: x_ has its value, and this its part.
  const auto add_decayed = [&](int column, int input, double left) {
    J.middleCols<3>(column) += left * B.middleCols<3>(input);
  };
  add_decayed(6, 0, gyro_left_);
  add_decayed(9, 3, accel_left_);
  J.middleCols<3>(12) += B.leftCols<3>() * told.rate.asDiagonal();
  J.middleCols<3>(15) += B.rightCols<3>() * told.force.asDiagonal();

  sum_.position += dt * sum_.velocity + R * moved;
  sum_.velocity += R * du;
  sum_.turn = (sum_.turn * step_turn).normalized();
  sum_.time += dt;
  x_.gyro_drift *= gyro.decay;
  x_.accel_drift *= accel.decay;
  gyro_left_ *= gyro.decay;
  accel_left_ *= accel.decay;
  return step;
}

SumResidual compare(const ImuSum& sum, const Eigen::Matrix<double, 18, 1>& change, const Estimate& start,
                    const Estimate& end, const Vector3d& earth_rate, const Gravity& gravity) {
  const double T = sum.time;
  const Fall fall = fall_of(T, start, earth_rate, gravity);
  const Matrix3d omega = skew(earth_rate), I = Matrix3d::Identity();
  const Matrix3d R_i = start.R_wb(), R_j = end.R_wb(), C = R_i.transpose();
  const Vector3d inertial_start = start.v_wb + omega * start.p_wb, inertial_end = end.v_wb + omega * end.p_wb;
  const Vector3d gained = fall.E * inertial_end - inertial_start - fall.velocity;
  const Vector3d went = fall.E * end.p_wb - start.p_wb - T * inertial_start - fall.position;
  const Eigen::Matrix<double, 9, 1> corrected = sum.by_imu * change;
  const Vector3d turn_change = corrected.segment<3>(kTurn);
  const Vector3d turned = so3_log((sum.turn * so3_exp(turn_change)).conjugate() * start.q_wb.conjugate() *
                                  so3_exp(T * earth_rate) * end.q_wb);
  SumResidual r;
  r.value << C * went - sum.position - corrected.segment<3>(kPlace),
      C * gained - sum.velocity - corrected.segment<3>(kSpeed), turned;

  const Matrix3d V_i = skew(start.v_wb), V_j = skew(end.v_wb);
  const Matrix3d right = so3_left_jacobian_inverse(-turned), left = so3_left_jacobian_inverse(turned);
  // Rows of places and speeds: by (ρ, ν, θ), where v = v̂ + ν − [v] θ and C = Ĉ (1 − [θ]).
  const auto at_start = [&](int row, const Vector3d& seen, double time, const Matrix3d& by_place, double along) {
    // `time`: what multiplies v̄; `along`: T/2 or T/3, where gravity is taken.
    const Matrix3d by_v = time * I + along * by_place;
    r.by_start.block<3, 3>(row, 0) = -C * ((row == kPlace ? I : Matrix3d::Zero().eval()) + time * omega + by_place);
    r.by_start.block<3, 3>(row, 3) = -C * by_v;
    r.by_start.block<3, 3>(row, 6) = C * (skew(seen) + by_v * V_i);
  };
  at_start(kPlace, went, T, fall.position_by_place, T / 3);
  at_start(kSpeed, gained, 1, fall.velocity_by_place, T / 2);
  r.by_start.block<3, 6>(kTurn, 0).setZero();
  r.by_start.block<3, 3>(kTurn, 6) = -right * R_j.transpose() * fall.E.transpose();

  const Matrix3d CE = C * fall.E;
  r.by_end.setZero();
  r.by_end.block<3, 3>(kPlace, 0) = CE;
  r.by_end.block<3, 3>(kSpeed, 0) = CE * omega;
  r.by_end.block<3, 3>(kSpeed, 3) = CE;
  r.by_end.block<3, 3>(kSpeed, 6) = -CE * V_j;
  r.by_end.block<3, 3>(kTurn, 6) = right * R_j.transpose();

  r.by_imu = -sum.by_imu;
  r.by_imu.middleRows<3>(kTurn) = (-left * so3_left_jacobian(-turn_change) * sum.by_imu.middleRows<3>(kTurn)).eval();
  return r;
}

Estimate carry(const ImuSum& sum, const Eigen::Matrix<double, 9, 1>& residual, const Estimate& start,
               const Vector3d& earth_rate, const Gravity& gravity) {
  const double T = sum.time;
  const Fall fall = fall_of(T, start, earth_rate, gravity);
  const Matrix3d back = fall.E.transpose(), R_i = start.R_wb();
  const Vector3d inertial = start.v_wb + earth_rate.cross(start.p_wb);
  Estimate end = start;
  end.q_wb = (so3_exp(-T * earth_rate) * start.q_wb * sum.turn * so3_exp(residual.segment<3>(kTurn))).normalized();
  end.p_wb = back * (start.p_wb + T * inertial + fall.position + R_i * (sum.position + residual.segment<3>(kPlace)));
  end.v_wb = back * (inertial + fall.velocity + R_i * (sum.velocity + residual.segment<3>(kSpeed))) -
             earth_rate.cross(end.p_wb);
  return end;
}

}  // namespace piste
