#include "model/preintegration.h"

#include <cstddef>

#include "math/wide.h"
#include "model/three_rows.h"

namespace piste {
namespace {

constexpr int kPlace = 0, kSpeed = 3, kTurn = 6, kGyroDrift = 9, kAccelDrift = 12;

// Dependence of the rows of (ΔP, ΔV, ΔR) on (ΔP, ΔV, ΔR, rate, force).
constexpr std::array<int, 15> kOfPlace{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
constexpr std::array<int, 12> kOfSpeed{3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
constexpr std::array<int, 6> kOfTurn{6, 7, 8, 9, 10, 11};

template <std::size_t Rows>
PISTE_INSIDE void rows_of_sum(const double* const* columns, const double* const* in, double (*out)[Rows]) {
  three_rows(columns, kPlace, kOfPlace, in, Rows, *out, Rows);
  three_rows(columns, kSpeed, kOfSpeed, in, Rows, *out, Rows);
  three_rows(columns, kTurn, kOfTurn, in, Rows, *out, Rows);
}

// The covariance of a sum after a step, that of the drifts before it, and the derivatives of the sum; `white`:
// variances of the readings.
PISTE_WIDE void spread_sum(const SumStep& step, const Eigen::Matrix<double, 6, 1>& white,
                           Preintegration::Carried& carried) {
  constexpr std::size_t kRows = Preintegration::kRows;
  const double* columns[15];
  for (int k = 0; k < 9; ++k) columns[k] = step.by_sum.data() + std::ptrdiff_t{9} * k;
  for (int k = 0; k < 6; ++k) columns[9 + k] = step.by_reading.data() + std::ptrdiff_t{9} * k;
  const double* in[15];
  for (std::size_t k = 0; k < 15; ++k) in[k] = carried[k].data();
  alignas(32) double after[9][kRows];
  rows_of_sum(columns, in, after);
  // The same for the rows of the sum itself, of which twelve are a multiple of four.
  alignas(32) double turned[15][12] = {};
  for (std::size_t k = 0; k < 15; ++k) {
    for (std::size_t i = 0; i < 9; ++i) turned[k][i] = after[i][k];
  }
  for (int k = 0; k < 6; ++k) {
    for (int i = 0; i < 9; ++i) turned[9 + k][i] += white(k) * step.by_reading(i, k);
  }
  for (std::size_t k = 0; k < 15; ++k) in[k] = turned[k];
  alignas(32) double corner[9][12];
  rows_of_sum(columns, in, corner);
  for (std::size_t j = 0; j < 9; ++j) {
    for (std::size_t i = 9; i < kRows; ++i) carried[j][i] = after[j][i];
    for (std::size_t i = 0; i < 9; ++i) carried[j][i] = 0.5 * (corner[j][i] + corner[i][j]);
  }
}

// Γ of the position: Σ [φ]ⁿ / (n+2)!. The angle is that of the Earth in seconds: two terms beyond the first are exact.
Matrix3d double_integral(const Vector3d& angle) {
  const Matrix3d S = skew(angle);
  return 0.5 * Matrix3d::Identity() + S / 6 + S * S / 24;
}

// The effect of the rotating Earth and of gravity over an interval that begins at `start`.
struct Fall {
  Matrix3d E;                                     // Exp(T ω_ie)
  Vector3d velocity, position;                    // T J_l G_v, T² Γ G_p
  Matrix3d velocity_by_place, position_by_place;  // their derivatives by p; by v: T/2 and T/3 times these
};

Fall fall_of(double T, const Estimate& start, const Vector3d& earth_rate, const Gravity& gravity) {
  const Vector3d angle = T * earth_rate;
  const Matrix3d omega = skew(earth_rate), by_place = gravity.gradient + omega * omega;
  const auto gravitation = [&](const Vector3d& p) { return Vector3d(gravity.at(p) + omega * (omega * p)); };
  const Matrix3d once = T * so3_left_jacobian(angle), twice = T * T * double_integral(angle);
  return {so3_exp(angle).toRotationMatrix(), once * gravitation(start.p_wb + T / 2 * start.v_wb),
          twice * gravitation(start.p_wb + T / 3 * start.v_wb), once * by_place, twice * by_place};
}

// The ends of an interval, compared with the preintegrated samples: `went` and `gained` in w, at the start.
struct Ends {
  Fall fall;
  Matrix3d omega, R_j, C;
  Vector3d gained, went, turn_change, turned;
  Eigen::Matrix<double, 9, 1> value;

  // `corrected`: the first-order correction of the sum.
  Ends(const SummedMotion& sum, const Eigen::Matrix<double, 9, 1>& corrected, const Estimate& start,
       const Estimate& end, const Vector3d& earth_rate, const Gravity& gravity)
      : fall(fall_of(sum.time, start, earth_rate, gravity)),
        omega(skew(earth_rate)),
        R_j(end.R_wb()),
        C(start.R_wb().transpose()) {
    const double T = sum.time;
    const Vector3d inertial_start = start.v_wb + omega * start.p_wb, inertial_end = end.v_wb + omega * end.p_wb;
    gained = fall.E * inertial_end - inertial_start - fall.velocity;
    went = fall.E * end.p_wb - start.p_wb - T * inertial_start - fall.position;
    turn_change = corrected.segment<3>(kTurn);
    turned = so3_log((sum.turn * so3_exp(turn_change)).conjugate() * start.q_wb.conjugate() * so3_exp(T * earth_rate) *
                     end.q_wb);
    value << C * went - sum.position - corrected.segment<3>(kPlace),
        C * gained - sum.velocity - corrected.segment<3>(kSpeed), turned;
  }
};

}  // namespace

SumStep Preintegration::move(const ImuStep& measured, const DriftStep& gyro, const DriftStep& accel) {
  const ImuStep s = correct(measured, x_);
  const double dt = s.dt;
  const Vector3d turn = coned_rotation(s), du = sculled_velocity(s);
  const Quaterniond step_turn = so3_exp(turn);
  const Matrix3d R = motion_.turn.toRotationMatrix(), R_half = (motion_.turn * so3_exp(0.5 * turn)).toRotationMatrix();
  const Vector3d moved = 0.5 * dt * du - dt * dt * dt / 12 * (s.force_slope + s.dtheta.cross(s.dvel) / (dt * dt));

  SumStep step;
  Matrix9d& A = step.by_sum;
  A.setIdentity();
  A.block<3, 3>(kPlace, kSpeed).diagonal().setConstant(dt);
  A.block<3, 3>(kPlace, kTurn) = -R * skew(moved);
  A.block<3, 3>(kSpeed, kTurn) = -R * skew(du);
  A.block<3, 3>(kTurn, kTurn) = step_turn.toRotationMatrix().transpose();
  // true = (measured − bias − drift) / (1 + scale)
  const Vector3d gyro_gain = (1 + x_.gyro_scale.array()).inverse(), accel_gain = (1 + x_.accel_scale.array()).inverse();
  const Matrix3d swing = -0.5 * dt * (A.block<3, 3>(kSpeed, kTurn) * gyro_gain.asDiagonal());
  Matrix96d& B = step.by_reading;
  B.setZero();
  B.block<3, 3>(kPlace, 0) = dt / 3 * swing;
  B.block<3, 3>(kSpeed, 0) = swing;
  B.block<3, 3>(kTurn, 0) = -dt * (so3_left_jacobian(-turn) * gyro_gain.asDiagonal());
  B.block<3, 3>(kSpeed, 3) = -dt * (R_half * accel_gain.asDiagonal());
  B.block<3, 3>(kPlace, 3) = 0.5 * dt * B.block<3, 3>(kSpeed, 3);

  motion_.position += dt * motion_.velocity + R * moved;
  motion_.velocity += R * du;
  motion_.turn = (motion_.turn * step_turn).normalized();
  motion_.time += dt;
  x_.gyro_drift *= gyro.decay;
  x_.accel_drift *= accel.decay;
  return step;
}

SumStep Preintegration::add(const ImuStep& measured, const StepNoise& noise, const BodyMotion& reference,
                            const DriftStep& gyro, const DriftStep& accel) {
  const double dt = measured.dt;
  SumStep step = move(measured, gyro, accel);
  // The inputs of the step: rows of the drifts' covariance, and the present drift as a function of each error of the
  // IMU. A drift at the start has decayed since: x_ has its present value, and `left` its remaining fraction.
  auto row = static_cast<std::size_t>(kDerivatives);
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    const double left = b.block == Block::kGyroDrift ? gyro_left_ : b.block == Block::kAccelDrift ? accel_left_ : 1;
    for (int k = 0; k < b.size(); ++k, ++row) {
      const ImuErrorElement& e = b.elements[static_cast<std::size_t>(k)];
      auto& input = carried_[static_cast<std::size_t>(kGyroDrift) + static_cast<std::size_t>(e.input)];
      input[row] = e.signal == kUnitSignal ? left : signal(e.signal, reference.rate, reference.force);
    }
  }
  Eigen::Matrix<double, 6, 1> white;
  white << noise.gyro / dt, noise.accel / dt;
  spread_sum(step, white, carried_);
  // White noise within the step gives the position a variance of dt³/3 times its squared density; the step's mean
  // explains dt³/4 of it.
  const auto push = step.by_reading.block<3, 3>(kSpeed, 3);
  const Matrix3d within_step = dt * dt / 12 * (push * white.tail<3>().asDiagonal() * push.transpose());
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      carried_[j][i] += within_step(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  // The drifts themselves.
  for (int k = 0; k < 6; ++k) {
    const auto column = static_cast<std::size_t>(kGyroDrift) + static_cast<std::size_t>(k);
    const DriftStep& of = k < 3 ? gyro : accel;
    for (std::size_t i = 0; i < 9; ++i) carried_[column][i] = carried_[i][column] *= of.decay;
    for (std::size_t l = 9; l < 15; ++l) carried_[column][l] *= of.decay * (l < 12 ? gyro : accel).decay;
    carried_[column][column] += of.variance(k % 3);
  }
  gyro_left_ *= gyro.decay;
  accel_left_ *= accel.decay;
  return step;
}

ImuSum Preintegration::sum() const {
  ImuSum out;
  static_cast<SummedMotion&>(out) = motion_;
  for (std::size_t j = 0; j < 15; ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    for (Eigen::Index i = 0; i < 15; ++i) out.noise(i, column) = carried_[j][static_cast<std::size_t>(i)];
    if (j >= 9) continue;
    for (Eigen::Index i = 0; i < kImuErrorSize; ++i) {
      out.by_imu(column, i) = carried_[j][static_cast<std::size_t>(kDerivatives) + static_cast<std::size_t>(i)];
    }
  }
  return out;
}

void add_to_scales(ImuSum::ByImu& by_imu, const SumStep& step, const BodyMotion& reference) {
  auto scales = by_imu.rightCols<kImuErrorSize - kConstantErrors>();
  const Eigen::Matrix<double, 3, kImuErrorSize - kConstantErrors> turns = scales.middleRows<3>(kTurn);
  scales.middleRows<3>(kPlace) += step.by_sum(kPlace, kSpeed) * scales.middleRows<3>(kSpeed) +
                                  step.by_sum.block<3, 3>(kPlace, kTurn).lazyProduct(turns);
  scales.middleRows<3>(kSpeed) += step.by_sum.block<3, 3>(kSpeed, kTurn).lazyProduct(turns);
  scales.middleRows<3>(kTurn) = step.by_sum.block<3, 3>(kTurn, kTurn).lazyProduct(turns);
  int column = 0;
  for (const ImuErrorBlock& b : kImuErrorBlocks) {
    for (int k = 0; k < b.size(); ++k, ++column) {
      const ImuErrorElement& e = b.elements[static_cast<std::size_t>(k)];
      if (e.signal == kUnitSignal) continue;
      by_imu.col(column) += signal(e.signal, reference.rate, reference.force) * step.by_reading.col(e.input);
    }
  }
}

Eigen::Matrix<double, 9, 1> white_noise_of(const SumStep& step, const StepNoise& noise, double dt,
                                           const Eigen::Matrix<double, 9, 1>& vector) {
  Eigen::Matrix<double, 6, 1> pulled = step.by_reading.transpose().lazyProduct(vector);
  pulled.head<3>().array() *= noise.gyro.array() / dt;
  pulled.tail<3>().array() *= noise.accel.array() / dt;
  Eigen::Matrix<double, 9, 1> out = step.by_reading.lazyProduct(pulled);
  const auto push = step.by_reading.block<3, 3>(kSpeed, 3);
  const Vector3d within_step = (push.transpose() * vector.head<3>()).cwiseProduct(noise.accel) / dt;
  out.head<3>() += dt * dt / 12 * (push * within_step);
  return out;
}

SumResidual compare(const ImuSum& sum, const ImuErrorVector& change, const Estimate& start, const Estimate& end,
                    const Vector3d& earth_rate, const Gravity& gravity) {
  const Ends e(sum, sum.by_imu * change, start, end, earth_rate, gravity);
  const Matrix3d I = Matrix3d::Identity(), V_i = skew(start.v_wb), V_j = skew(end.v_wb);
  const Matrix3d right = so3_left_jacobian_inverse(-e.turned), left = so3_left_jacobian_inverse(e.turned);
  SumResidual r;
  r.value = e.value;
  // Rows of position and velocity: by (ρ, ν, θ), where v = v̂ + ν − [v] θ and C = Ĉ (1 − [θ]).
  const auto at_start = [&](int row, const Vector3d& seen, double time, const Matrix3d& by_place, double along) {
    // `time`: what multiplies v̄; `along`: T/2 or T/3, where gravity is taken.
    const Matrix3d by_v = time * I + along * by_place;
    r.by_start.block<3, 3>(row, 0) = -e.C * ((row == kPlace ? I : Matrix3d::Zero().eval()) + time * e.omega + by_place);
    r.by_start.block<3, 3>(row, 3) = -e.C * by_v;
    r.by_start.block<3, 3>(row, 6) = e.C * (skew(seen) + by_v * V_i);
  };
  at_start(kPlace, e.went, sum.time, e.fall.position_by_place, sum.time / 3);
  at_start(kSpeed, e.gained, 1, e.fall.velocity_by_place, sum.time / 2);
  r.by_start.block<3, 6>(kTurn, 0).setZero();
  r.by_start.block<3, 3>(kTurn, 6) = -right * e.R_j.transpose() * e.fall.E.transpose();

  const Matrix3d CE = e.C * e.fall.E;
  r.by_end.setZero();
  r.by_end.block<3, 3>(kPlace, 0) = CE;
  r.by_end.block<3, 3>(kSpeed, 0) = CE * e.omega;
  r.by_end.block<3, 3>(kSpeed, 3) = CE;
  r.by_end.block<3, 3>(kSpeed, 6) = -CE * V_j;
  r.by_end.block<3, 3>(kTurn, 6) = right * e.R_j.transpose();

  r.by_imu = -sum.by_imu;
  r.by_imu.middleRows<3>(kTurn) = (-left * so3_left_jacobian(-e.turn_change) * sum.by_imu.middleRows<3>(kTurn)).eval();
  return r;
}

Eigen::Matrix<double, 9, 1> residual_of(const SummedMotion& sum, const Estimate& start, const Estimate& end,
                                        const Vector3d& earth_rate, const Gravity& gravity) {
  return Ends(sum, Eigen::Matrix<double, 9, 1>::Zero(), start, end, earth_rate, gravity).value;
}

SumTie tie_ends(const ImuSum& sum, const ImuErrorVector& change, const Estimate& start, const Estimate& end,
                const Vector3d& earth_rate, const Gravity& gravity) {
  const Ends e(sum, sum.by_imu * change, start, end, earth_rate, gravity);
  const double T = sum.time;
  const Matrix3d I = Matrix3d::Identity(), V_i = skew(start.v_wb), back = e.fall.E.transpose();
  SumTie t;
  t.value = e.value;
  t.place = back * e.C.transpose();
  t.turn = e.R_j * so3_left_jacobian(-e.turned);
  t.velocity = skew(end.v_wb);
  t.rate = e.omega;
  // −by_end⁻¹ by_start: the axes of the body cancel.
  t.by_start.block<3, 6>(kTurn, 0).setZero();
  t.by_start.block<3, 3>(kTurn, 6) = back;
  const auto at_start = [&](int row, const Vector3d& seen, const Matrix3d& by_p, const Matrix3d& by_v) {
    t.by_start.block<3, 3>(row, 0) = back * by_p;
    t.by_start.block<3, 3>(row, 3) = back * by_v;
    t.by_start.block<3, 3>(row, 6) = -back * (skew(seen) + by_v * V_i);
  };
  at_start(kPlace, e.went, I + T * e.omega + e.fall.position_by_place, T * I + T / 3 * e.fall.position_by_place);
  at_start(kSpeed, e.gained, e.omega + e.fall.velocity_by_place, I + T / 2 * e.fall.velocity_by_place);
  auto speeds = t.by_start.middleRows<3>(kSpeed);
  speeds -= e.omega * t.by_start.middleRows<3>(kPlace);
  speeds.rightCols<3>() += t.velocity * back;

  t.by_imu.topRows<6>() = sum.by_imu.topRows<6>();
  t.by_imu.bottomRows<3>() =
      so3_left_jacobian_inverse(e.turned) * so3_left_jacobian(-e.turn_change) * sum.by_imu.bottomRows<3>();
  for (Eigen::Index k = 0; k < t.by_imu.cols(); ++k) t.turn_to_end(t.by_imu.col(k).data());
  t.shift = -t.value;
  t.turn_to_end(t.shift.data());
  return t;
}

Estimate carry(const SummedMotion& sum, const Eigen::Matrix<double, 9, 1>& residual, const Estimate& start,
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
