#pragma once
/// The true motion of a simulated run: position, velocity, attitude, and the output of a perfect IMU, exact at any
/// time.

#include <memory>
#include <vector>

#include "piste/core/log.h"
#include "piste/sim/motion.h"

namespace piste {

/// The motion of a body b at one time.
struct TruthState {
  double time = 0;
  Quaterniond q_wb;
  Vector3d p_wb, v_wb, acceleration;  ///< in w; the acceleration is the second derivative of p_wb
  Vector3d w_ib_b, w_ib_b_dot;        ///< angular rate against inertial space, and its derivative
  Vector3d f_ib_b;                    ///< specific force
};

/// The mean angular rate and the mean specific force over an interval, in the body's own axes, which turn with it.
struct MeanInertial {
  Vector3d gyro, accel;
};

/// The truth of one body. All bodies of a run are fixed to one another and share one motion. So `attached` is exact:
/// f_ib_b = R_wbᵀ (a − g_w(p) + 2 ω_ie × v) and w_ib_b = R_wbᵀ ω_ie + w_wb_b, with a, v, p of that body.
class Truth {
 public:
  /// The trunk itself, from `start_time` [GPS seconds of week] on.
  Truth(const World& world, const MotionOptions& motion, std::uint64_t seed, double start_time);

  /// A body b that is fixed to this one (r), with the axes q_rb and the origin at p_rb_r.
  Truth attached(const Quaterniond& q_rb, const Vector3d& p_rb_r) const;

  TruthState at(double time) const;

  /// Means over (start, end] by Gauss-Legendre quadrature of 8th order, on pieces of at most 10 ms. They are exact to
  /// 1e-9 of the signal at 10 Hz. @pre start < end
  MeanInertial mean(double start, double end) const;

  const World& world() const { return run_->world; }
  double start_time() const { return run_->start_time; }
  double end_time() const { return run_->start_time + run_->motion.options().duration(); }
  /// The time under way, between the rests.
  Interval under_way() const;
  /// The gates of the course that the run follows, which are the same for all bodies; none without a course.
  std::vector<CourseGate> gates() const { return run_->motion.gates(); }

 private:
  struct Run {
    World world;
    Motion motion;
    double start_time;
    std::vector<Gravity> gravity;  // at every second: linear to rounding between them
  };
  explicit Truth(std::shared_ptr<const Run> run) : run_(std::move(run)) {}

  std::shared_ptr<const Run> run_;
  Quaterniond q_tb_ = Quaterniond::Identity();  // of the trunk t
  Vector3d p_tb_t_ = Vector3d::Zero();
};

/// The time at which a body passes a vertical plane forwards [GPS seconds of week]: the root of d · (p(t) − place) that
/// Newton's method reaches from the time `about`, good to a nanosecond where the body is under way there.
/// `place` is in w and `direction`, d, is the plane's normal in w. Throws DataError if it does not pass there.
///
///     const CourseGate gate = truth.gates().front();
///     const double t = crossing_time(truth, gate.place, {std::cos(gate.heading), std::sin(gate.heading), 0},
///                                    truth.start_time() + gate.about);
double crossing_time(const Truth& body, const Vector3d& place, const Vector3d& direction, double about);

}  // namespace piste
