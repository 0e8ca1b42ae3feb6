#include "piste/sim/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "piste/core/error.h"

namespace piste {

Truth::Truth(const World& world, const MotionOptions& motion, std::uint64_t seed, double start_time) {
  Run run{world, Motion(motion, seed), start_time, {}};
  const int seconds = static_cast<int>(motion.duration() + 1);
  for (int t = 0; t <= seconds; ++t) run.gravity.push_back(world.gravity(run.motion.at(t).p_wt));
  run_ = std::make_shared<const Run>(std::move(run));
}

Truth Truth::attached(const Quaterniond& q_rb, const Vector3d& p_rb_r) const {
  Truth other(run_);
  other.q_tb_ = q_tb_ * q_rb;
  other.p_tb_t_ = p_tb_t_ + q_tb_ * p_rb_r;
  return other;
}

TruthState Truth::at(double time) const {
  const double t = time - run_->start_time;
  const MotionState trunk = run_->motion.at(t);
  const Vector3d& earth_rate = run_->world.earth_rate();
  const Vector3d& w = trunk.w_wt_t;

  TruthState state;
  state.time = time;
  state.q_wb = trunk.q_wt * q_tb_;
  state.p_wb = trunk.p_wt + trunk.q_wt * p_tb_t_;
  state.v_wb = trunk.v_wt + trunk.q_wt * w.cross(p_tb_t_);
  state.acceleration = trunk.a_wt + trunk.q_wt * (trunk.w_wt_t_dot.cross(p_tb_t_) + w.cross(w.cross(p_tb_t_)));

  const Quaterniond q_bt = q_tb_.conjugate(), q_bw = state.q_wb.conjugate();
  const Vector3d earth_rate_b = q_bw * earth_rate, w_wb_b = q_bt * w;
  state.w_ib_b = earth_rate_b + w_wb_b;
  state.w_ib_b_dot = q_bt * trunk.w_wt_t_dot - w_wb_b.cross(earth_rate_b);

  const auto last = static_cast<double>(run_->gravity.size() - 1);
  const Gravity& gravity = run_->gravity[static_cast<std::size_t>(std::clamp(std::round(t), 0.0, last))];
  state.f_ib_b = q_bw * (state.acceleration - gravity.at(state.p_wb) + 2 * earth_rate.cross(state.v_wb));
  return state;
}

MeanInertial Truth::mean(double start, double end) const {
  constexpr double kPiece = 0.01;
  constexpr std::array kNode{0.33998104358485626, 0.86113631159405258};
  constexpr std::array kWeight{0.65214515486254614, 0.34785484513745386};
  const int pieces = std::max(1, static_cast<int>(std::ceil((end - start) / kPiece - 1e-6)));
  const double half = (end - start) / (2 * pieces);

  MeanInertial sum{Vector3d::Zero(), Vector3d::Zero()};
  for (int piece = 0; piece < pieces; ++piece) {
    const double middle = start + (2 * piece + 1) * half;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
      for (const double side : {-1.0, 1.0}) {
        const TruthState state = at(middle + side * kNode[i] * half);
        sum.gyro += kWeight[i] * state.w_ib_b;
        sum.accel += kWeight[i] * state.f_ib_b;
      }
    }
  }
  return {sum.gyro / (2 * pieces), sum.accel / (2 * pieces)};
}

Interval Truth::under_way() const {
  const MotionOptions& motion = run_->motion.options();
  const double start = run_->start_time + motion.rest_before;
  return {start, start + motion.run};
}

double crossing_time(const Truth& body, const Vector3d& place, const Vector3d& direction, double about) {
  constexpr int kMost = 30;
  constexpr double kEnough = 1e-10;  // s: below it GPS seconds of week have no digits
  double t = about;
  for (int i = 0; i < kMost; ++i) {
    const TruthState state = body.at(t);
    const double speed = direction.dot(state.v_wb);
    if (!(speed > 0)) break;
    const double step = direction.dot(place - state.p_wb) / speed;
    t += step;
    if (std::abs(step) < kEnough) return t;
  }
  throw DataError("", fmt::format("the body does not pass this plane forwards near {:.3f} s", about));
}

}  // namespace piste
