#pragma once
/// The simulated motion of a person over a run: rest, a descent or a lap, rest. It is a smooth function of time with
/// exact derivatives.
///
/// The path is a curve c(u) in the horizontal plane of `w`: an arc that turns by `net_turn` in all, with swings to both
/// sides, on a slope. u(t) starts and stops by a polynomial of degree 10 (five times continuously differentiable). The
/// trunk looks along the tangent of c and leans into the turn. Both are functions of u alone, so they are defined at
/// rest as well. Sway, slow turning and vibration are sums of sines with random phases. Everything is evaluated as
/// Taylor series (jet.h): no number comes from a difference or an integration.

#include <cstdint>
#include <optional>
#include <vector>

#include "piste/math/so3.h"
#include "piste/sim/jet.h"
#include "piste/sim/random.h"

namespace piste {

/// A sum of sines: smooth, stationary, zero mean.
class Wobble {
 public:
  /// `count` sines with random phases. [low, high] Hz is divided into `count` equal parts, and each sine has a random
  /// frequency in one of them. In the derivative of order `order` all sines have the same amplitude, and their sum has
  /// the root mean square `rms`.
  Wobble(double rms, int order, double low, double high, int count, RandomStream& random);
  Jet at(double t) const;

 private:
  struct Sine {
    double amplitude, omega, phase;
  };
  std::vector<Sine> sines_;
};

/// A course that several runs share. Its line is drawn once, by its own seed; each run then has a line, a speed and a
/// rhythm of its own, by the seed of the run.
struct CourseOptions {
  int gates = 2;           ///< at equal distances in plan, from where speed is reached to where braking begins
  double offset = 0;       ///< rms distance of a run's line from the course's, to the side [m]
  double speed = 0;        ///< 1-sigma of a run's mean speed about `MotionOptions::speed`, as a ratio of it
  std::uint64_t seed = 1;  ///< of the course's line
};

/// A gate of a course: the vertical plane through `place`, in w, normal to `heading`. That is the direction of the
/// course without its turns, as gates stand on a slope: planes that face alike cancel what errors of two gates share.
struct CourseGate {
  Vector3d place;
  double heading;
  double about;  ///< seconds after the start of the recording at which the trunk's path is about there
};

/// Options of the motion, SI and radians. Vectors of the trunk have the axes forward, right, down. Zero switches a part
/// off.
struct MotionOptions {
  double rest_before = 180, run = 90, rest_after = 180;
  double start_time = 6, stop_time = 5;  ///< duration of speeding up and of slowing down
  double heading = 0;                    ///< of the trunk at the start
  double speed = 8;                      ///< along the path while cruising, averaged over a swing
  double speed_swing = 0.3;              ///< amplitude of its variation
  double speed_period = 17;
  double net_turn = 0;         ///< of the path over the run
  double slope = 0.2;          ///< of the path, down positive
  double cycle = 6;            ///< one swing to the right and one to the left
  double turn = 0.3;           ///< largest angle between path and arc
  double turn_variation = .1;  ///< of the swings' sizes and lengths, as a ratio
  double lean = 1;             ///< roll divided by that of perfect balance, atan(a_lateral / g)
  double crouch = 0;           ///< pitch of the trunk under way less that at rest

  Vector3d sway_velocity = Vector3d::Constant(0.005);  ///< rms of a standing person, w axes, 0.1 to 1 Hz
  Vector3d sway_rate = Vector3d::Constant(0.0026);     ///< rms of Euler rates, 0.1 to 1 Hz
  double turning_rate = 0.0017;                        ///< rms of slow changes of heading, 0.005 to 0.02 Hz
  Vector3d balance_rate = Vector3d::Zero();    ///< rms of Euler rates under way, 0.2 to 0.8 Hz: arms, poles, bumps
  Vector3d vibration = Vector3d::Constant(1);  ///< rms of trunk acceleration under way, 4 to 10 Hz
  Vector3d vibration_rate = Vector3d::Zero();  ///< rms of Euler rates under way, 4 to 10 Hz

  /// Without it each run has a line of its own. With it, the options above describe a run of medium speed.
  std::optional<CourseOptions> course = std::nullopt;

  double duration() const { return rest_before + run + rest_after; }
  /// Throws ConfigError if no body can move so.
  void validate() const;
};

/// Position and attitude of the trunk t in w, with the derivatives that a body fixed to it needs.
struct MotionState {
  Quaterniond q_wt;
  Vector3d p_wt, v_wt, a_wt;    ///< p_wt and its first and second derivative
  Vector3d w_wt_t, w_wt_t_dot;  ///< angular rate of t against w, in t, and its derivative
};

/// The motion of one run.
class Motion {
 public:
  Motion(const MotionOptions& options, std::uint64_t seed);
  /// The trunk `t` seconds after the start of the recording. Before and after the recording it is at rest.
  MotionState at(double t) const;
  /// With a course, `run` is how long this run takes.
  const MotionOptions& options() const { return options_; }
  /// The gates of the course, in the order in which they are passed; none without one.
  std::vector<CourseGate> gates() const;

 private:
  struct Path {
    Jet north, east, heading, curvature;
  };
  Path path(const Jet& u) const;
  void take_own_way(const CourseOptions& course, std::uint64_t seed);
  double time_at(double u) const;
  Jet progress(double t, Jet* envelope) const;

  MotionOptions options_;
  double cruise_ = 0;                   // du/dt
  double arc_ = 0;                      // curvature of the arc, per u
  double swing_ = 0, wave_number_ = 0;  // amplitude and wave number of a(u)
  double phase_[4] = {};
  double heading_ = 0, north_ = 0, east_ = 0;  // so that the path starts at the origin with the given heading
  std::vector<Wobble> sway_, sway_angle_, balance_, vibration_, vibration_angle_;
  std::vector<Wobble> turning_;
  std::vector<Wobble> own_line_;  // of one run of a course: to the side, over u; empty without one
};

}  // namespace piste
