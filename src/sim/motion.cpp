#include "piste/sim/motion.h"

#include <numbers>

#include "piste/core/error.h"
#include "piste/math/earth.h"

namespace piste {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

// 0 for x ≤ 0, 1 for x ≥ 1, four times continuously differentiable.
Jet smooth_step(const Jet& x) {
  if (x.value() <= 0) return 0;
  if (x.value() >= 1) return 1;
  const Jet x2 = x * x;
  return x2 * x2 * x * (126 + x * (-420 + x * (540 + x * (-315 + x * 70))));
}

// ∫ smooth_step over (−∞, x]: x − 1/2 for x ≥ 1.
Jet smooth_ramp(const Jet& x) {
  if (x.value() <= 0) return 0;
  if (x.value() >= 1) return x - 0.5;
  const Jet x2 = x * x;
  return x2 * x2 * x2 * (21 + x * (-60 + x * (67.5 + x * (-35 + x * 7))));
}

std::vector<Wobble> triad(const Vector3d& rms, int order, double low, double high, RandomStream random) {
  std::vector<Wobble> axes;
  axes.reserve(3);
  for (int i = 0; i < 3; ++i) axes.emplace_back(rms(i), order, low, high, 8, random);
  return axes;
}

Vector3d derivative_of(const Jet (&v)[3], std::size_t n) { return {v[0](n), v[1](n), v[2](n)}; }

}  // namespace

Wobble::Wobble(double rms, int order, double low, double high, int count, RandomStream& random) {
  for (int i = 0; i < count; ++i) {
    const double omega = kTwoPi * (low + (high - low) * (i + random.uniform()) / count);
    const double amplitude = rms * std::sqrt(2.0 / count) / std::pow(omega, order);
    const double phase = kTwoPi * random.uniform();
    if (rms != 0) sines_.push_back({amplitude, omega, phase});
  }
}

Jet Wobble::at(double t) const {
  Jet sum;
  for (const Sine& sine : sines_) {
    const double angle = sine.omega * t + sine.phase;
    const double value[2] = {sine.amplitude * std::sin(angle), sine.amplitude * std::cos(angle)};
    double factor = 1;  // ωⁿ/n!, its sign that of the n-th derivative of sine and cosine
    for (std::size_t n = 0; n <= Jet::kOrder; ++n) {
      sum.c[n] += (n % 4 < 2 ? factor : -factor) * value[n % 2];
      factor *= sine.omega / static_cast<double>(n + 1);
    }
  }
  return sum;
}

void MotionOptions::validate() const {
  const auto require = [](bool good, const char* what) {
    if (!good) throw ConfigError("motion", what);
  };
  require(rest_before >= 0 && rest_after >= 0, "rest is negative; give 0 s or more");
  require(start_time > 0 && stop_time > 0, "start_time and stop_time must be positive");
  require(run > start_time + stop_time, "run must be longer than start_time and stop_time together");
  require(speed > 0 && cycle > 0 && speed_period > 0, "speed, cycle and speed_period must be positive");
  require(std::abs(speed_swing) < speed, "speed_swing must be smaller than speed");
  require(turn >= 0 && turn < 1.4, "turn must lie between 0 and 80 deg");
  require(std::abs(slope) < 1.2, "slope must lie between -68 and 68 deg");
  require(turn_variation >= 0 && turn_variation <= 0.5, "turn_variation must lie between 0 and 0.5");
  if (!course) return;
  require(course->gates >= 2, "a course has two gates at least: a start and a finish");
  require(course->offset >= 0, "the course's offset must not be negative; it is an rms");
  require(course->speed >= 0 && course->speed <= 0.1, "the course's speed must lie between 0 and 10 %");
}

Motion::Motion(const MotionOptions& options, std::uint64_t seed)
    : options_(options),
      sway_(triad(options.sway_velocity, 1, 0.1, 1, {seed, "sway"})),
      sway_angle_(triad(options.sway_rate, 1, 0.1, 1, {seed, "sway angle"})),
      balance_(triad(options.balance_rate, 1, 0.2, 0.8, {seed, "balance"})),
      vibration_(triad(options.vibration, 2, 4, 10, {seed, "vibration"})),
      vibration_angle_(triad(options.vibration_rate, 1, 4, 10, {seed, "vibration angle"})),
      turning_(triad({0, 0, options.turning_rate}, 1, 0.005, 0.02, {seed, "turning"})) {
  options_.validate();
  RandomStream random(options_.course ? options_.course->seed : seed, "path");
  for (double& phase : phase_) phase = kTwoPi * random.uniform();

  // Path length per u, averaged over a swing: sqrt(1 + tan² turn cos² + tan² slope).
  constexpr int kSamples = 64;
  const double tan_turn = std::tan(options_.turn), tan_slope = std::tan(options_.slope);
  double stretch = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double lateral = tan_turn * std::cos(kTwoPi * i / kSamples);
    stretch += std::sqrt(1 + lateral * lateral + tan_slope * tan_slope) / kSamples;
  }
  cruise_ = options_.speed / stretch;
  wave_number_ = kTwoPi / (cruise_ * options_.cycle);
  swing_ = tan_turn / wave_number_;
  arc_ = options_.net_turn / (cruise_ * (options_.run - (options_.start_time + options_.stop_time) / 2));

  const Path start = path(0);
  heading_ = options_.heading - start.heading.value();
  const Path turned = path(0);
  north_ = -turned.north.value();
  east_ = -turned.east.value();
  if (options_.course) take_own_way(*options_.course, seed);
}

// Once the course is placed: a line at a distance from it, and another speed over the same length.
void Motion::take_own_way(const CourseOptions& course, std::uint64_t seed) {
  RandomStream random(seed, "own way");
  phase_[3] = kTwoPi * random.uniform();
  const double factor = 1 + course.speed * random.normal();
  const double ramps = (options_.start_time + options_.stop_time) / 2;
  options_.run = (options_.run - ramps) / factor + ramps;
  options_.speed *= factor;
  options_.validate();
  cruise_ *= factor;
  constexpr double kLongest = 8, kShortest = 2;  // swings: slower than the turns, which all take alike
  constexpr int kSines = 8;
  const double swings = wave_number_ / kTwoPi;
  own_line_.emplace_back(course.offset, 0, swings / kLongest, swings / kShortest, kSines, random);
}

// Where the path's parameter is u, seconds after the start of the recording.
double Motion::time_at(double u) const {
  double low = options_.rest_before, high = options_.rest_before + options_.run;
  constexpr int kHalvings = 40;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = (low + high) / 2;
    Jet envelope;
    (progress(middle, &envelope).value() < u ? low : high) = middle;
  }
  return (low + high) / 2;
}

std::vector<CourseGate> Motion::gates() const {
  std::vector<CourseGate> gates;
  if (!options_.course) return gates;
  Motion course = *this;
  course.own_line_.clear();
  const double medium = kTwoPi / (wave_number_ * options_.cycle);  // du/dt of a run at the course's own speed
  const double length = cruise_ * (options_.run - (options_.start_time + options_.stop_time) / 2);
  const double first = medium * options_.start_time / 2, last = length - medium * options_.stop_time / 2;
  for (int i = 0; i < options_.course->gates; ++i) {
    const double u = first + (last - first) * i / (options_.course->gates - 1);
    const Path line = course.path(u);
    gates.push_back({.place = {line.north.value(), line.east.value(), std::tan(options_.slope) * u},
                     .heading = heading_ + arc_ * u,
                     .about = time_at(u)});
  }
  return gates;
}

// c(u) = arc(u) + a(u) · normal(u), its heading atan2(a', 1 − arc a) + arc u, and its signed curvature in the plane.
Motion::Path Motion::path(const Jet& u_of_t) const {
  const Jet u = Jet::variable(u_of_t.value());
  const double variation = options_.turn_variation;
  const Jet size = 1 + variation * sin(wave_number_ / 3.7 * u + phase_[0]);
  const Jet phase = wave_number_ * u + 2 * variation * sin(wave_number_ / 2.9 * u + phase_[1]) + phase_[2];
  Jet lateral = swing_ * size * sin(phase);
  for (const Wobble& own : own_line_) lateral += own.at(u.value());
  const Jet bearing = arc_ * u + heading_;
  const Jet along = 1 - arc_ * lateral, across = derivative(lateral);
  const Jet heading = bearing + atan2(across, along);
  const Jet stretch = sqrt(along * along + across * across);

  const Jet s = sin(bearing), c = cos(bearing);
  // sin(arc u)/arc and (1 − cos(arc u))/arc without a division by 0: the antiderivatives of cos and sin of bearing.
  const double half = arc_ * u.value() / 2;
  const double chord = u.value() * (std::abs(half) < 1e-9 ? 1 : std::sin(half) / half);
  Path p;
  p.north = north_ + antiderivative(c, chord * std::cos(heading_ + half)) - lateral * s;
  p.east = east_ + antiderivative(s, chord * std::sin(heading_ + half)) + lateral * c;
  p.heading = heading;
  p.curvature = derivative(heading) / stretch;
  return {compose(p.north, u_of_t), compose(p.east, u_of_t), compose(p.heading, u_of_t), compose(p.curvature, u_of_t)};
}

// u(t), and the envelope: 0 at rest, 1 under way.
Jet Motion::progress(double t, Jet* envelope) const {
  const Jet since_start = Jet::variable(t - options_.rest_before);
  const Jet since_braking = since_start - (options_.run - options_.stop_time);
  const Jet up = since_start / options_.start_time, down = since_braking / options_.stop_time;
  *envelope = smooth_step(up) - smooth_step(down);
  const double omega = kTwoPi / options_.speed_period;
  const double share = options_.speed_swing / options_.speed;
  const Jet surge = *envelope * (share / omega) * sin(omega * since_start + phase_[3]);
  return cruise_ * (options_.start_time * smooth_ramp(up) - options_.stop_time * smooth_ramp(down) + surge);
}

MotionState Motion::at(double t) const {
  Jet under_way;
  const Jet u = progress(t, &under_way);
  const Path path_now = path(u);
  const Jet position[3] = {path_now.north + sway_[0].at(t), path_now.east + sway_[1].at(t),
                           std::tan(options_.slope) * u + sway_[2].at(t)};

  const Jet speed_squared = [&] {
    const Jet north = derivative(path_now.north), east = derivative(path_now.east);
    return north * north + east * east;
  }();
  Jet angles[3] = {options_.lean * atan(speed_squared * path_now.curvature / kStandardGravity),
                   options_.crouch * under_way, path_now.heading};
  Jet shake[3];
  const bool resting = t <= options_.rest_before || t >= options_.rest_before + options_.run;
  for (std::size_t i = 0; i < 3; ++i) {
    angles[i] += sway_angle_[i].at(t) + turning_[i].at(t);
    if (resting) continue;  // what shakes under way would be multiplied by 0
    angles[i] += under_way * (balance_[i].at(t) + vibration_angle_[i].at(t));
    shake[i] = under_way * vibration_[i].at(t);
  }

  // Rate of the trunk from its Euler angles (roll φ, pitch θ, heading ψ), Groves eq. 2.57.
  const Jet sin_roll = sin(angles[0]), cos_roll = cos(angles[0]);
  const Jet sin_pitch = sin(angles[1]), cos_pitch = cos(angles[1]);
  const Jet roll_rate = derivative(angles[0]), pitch_rate = derivative(angles[1]), turn_rate = derivative(angles[2]);
  const Jet rate[3] = {roll_rate - turn_rate * sin_pitch, pitch_rate * cos_roll + turn_rate * sin_roll * cos_pitch,
                       turn_rate * cos_roll * cos_pitch - pitch_rate * sin_roll};

  // p = path + R d, with d the vibration in trunk axes.
  MotionState state;
  state.q_wt = from_euler(derivative_of(angles, 0));
  state.w_wt_t = derivative_of(rate, 0);
  state.w_wt_t_dot = derivative_of(rate, 1);
  const Vector3d d = derivative_of(shake, 0), d_dot = derivative_of(shake, 1), d_dot_dot = derivative_of(shake, 2);
  const Vector3d& w = state.w_wt_t;
  state.p_wt = derivative_of(position, 0) + state.q_wt * d;
  state.v_wt = derivative_of(position, 1) + state.q_wt * (w.cross(d) + d_dot);
  state.a_wt = derivative_of(position, 2) +
               state.q_wt * (state.w_wt_t_dot.cross(d) + w.cross(w.cross(d)) + 2 * w.cross(d_dot) + d_dot_dot);
  return state;
}

}  // namespace piste
