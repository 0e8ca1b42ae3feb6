#include "piste/solve/filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/model/attitude.h"
#include "piste/model/gnss.h"
#include "piste/model/magnetometer.h"
#include "piste/model/rest.h"

namespace piste {
namespace {

constexpr double kSameInstant = 1e-6;   // s: a fix nearer than this to an epoch does not split the step
constexpr double kGravityReach = 100;   // m: gravity is linear to 1e-9 m/s² over it
constexpr double kClippedSpread = 0.2;  // of the range: 1-sigma of what a clipped sample hides
constexpr double kLargestTilt = 0.2;    // rad that a readmission may add
constexpr double kMendable = 1;         // s between attitude fixes over which the body's axes are taken as one

}  // namespace

Covariance initial_covariance(const StateLayout& layout, const FilterOptions& o, const Start& start) {
  if (start.covariance.rows() == layout.size()) return start.covariance;
  Covariance P = Covariance::Zero(layout.size(), layout.size());
  P.topLeftCorner<9, 9>() = start.covariance;
  const auto set = [&](Block b, const Vector3d& sigma) {
    if (!layout.has(b)) return;
    P.diagonal().segment(layout.offset(b), info(b).size) = sigma.head(info(b).size).cwiseAbs2();
  };
  const auto all = [](double s) { return Vector3d::Constant(s); };
  set(Block::kGyroBias, all(o.sensor.gyro.bias));
  set(Block::kAccelBias, all(o.sensor.accel.bias));
  set(Block::kGyroDrift, all(initial_sigma(o.sensor.gyro.drift)));
  set(Block::kAccelDrift, all(initial_sigma(o.sensor.accel.drift)));
  set(Block::kGyroScale, all(o.sensor.gyro.scale));
  set(Block::kAccelScale, all(o.sensor.accel.scale));
  set(Block::kBoresight, all(o.priors.boresight));
  set(Block::kLeverArm, all(o.priors.lever_arm));
  set(Block::kGnssDelay, all(o.priors.gnss_delay));
  for (const GnssOptions& g : o.gnss) {
    if (g.drift) set(Block::kGnssPositionDrift, g.drift->sigma);
  }
  for (const AttitudeOptions& a : o.attitude) {
    if (a.drift) set(Block::kAttitudeDrift, a.drift->sigma);
    if (a.boresight_drift) set(Block::kBoresightDrift, a.boresight_drift->sigma);
  }
  return P;
}

Filter::Filter(const FilterOptions& options, const World& world, const Start& start) {
  options.validate();
  auto setup = std::make_shared<Setup>();
  setup->options = options;
  setup->layout = StateLayout(options.estimate);
  setup->world = world;
  for (int n = 1; n <= 3; ++n) setup->gate[static_cast<std::size_t>(n)] = chi_squared_quantile(options.gate, n);
  for (std::size_t i = 0; i < options.gnss.size(); ++i) {
    setup->sources.push_back(fmt::format("gnss[{}].position", i));
    setup->sources.push_back(fmt::format("gnss[{}].velocity", i));
  }
  setup->first_attitude = static_cast<int>(setup->sources.size());
  for (std::size_t i = 0; i < options.attitude.size(); ++i) setup->sources.push_back(fmt::format("attitude[{}]", i));
  setup->magnetic = static_cast<int>(setup->sources.size());
  setup->sources.emplace_back("magnetic");
  setup->start = setup->magnetic + 1;
  setup->sources.emplace_back("start.heading");
  setup->rest = setup->start + 1;
  setup->sources.emplace_back("rest.velocity");
  setup->sources.emplace_back("rest.rate");

  trust_ = Trust({setup->first_attitude, setup->rest, static_cast<int>(setup->sources.size())},
                 {options.readmit_after, options.distrust});
  state_ = {start.time, start.x, initial_covariance(setup->layout, options, start)};
  queue_.reserve(256);
  innovations_.reserve(256);
  gravity_ = world.gravity(start.x.p_wb);
  setup_ = std::move(setup);
  if (start.heading) enqueue({start.heading->time, setup_->start, 0, *start.heading});
}

void Filter::enqueue(Pending&& pending) {
  if (pending.time < state_.time - kSameInstant) {
    ++late_;
    return;
  }
  const auto later = [](const Pending& a, const Pending& b) {
    return a.time != b.time ? a.time < b.time : a.source < b.source;
  };
  queue_.insert(std::upper_bound(queue_.begin(), queue_.end(), pending, later), std::move(pending));
}

void Filter::add(int receiver, const GnssFix& fix) { enqueue({fix.time, 2 * receiver, receiver, fix}); }

void Filter::add(int reference, const AttitudeFix& fix) {
  enqueue({fix.time, setup_->first_attitude + reference, reference, fix});
}

void Filter::add(const MagneticSample& sample) {
  if (setup_->options.magnetic_sigma > 0) enqueue({sample.time, setup_->magnetic, 0, sample});
}

bool Filter::add(const ImuSample& sample) {
  const bool epoch = now_.has_value();
  if (epoch) process(&sample);
  before_ = now_;
  now_ = sample;
  return epoch;
}

bool Filter::finish() {
  if (!now_) return false;
  process(nullptr);
  now_.reset();
  return true;
}

Estimate Filter::predicted() const {
  Estimate x = state_.x;
  if (now_) {
    const ImuStep step = correct(make_step(before_ ? &*before_ : nullptr, *now_, nullptr), x);
    mechanize(x, step, setup_->world.earth_rate(), gravity_);
  }
  return x;
}

void Filter::process(const ImuSample* after) {
  const ImuSample& sample = *now_;
  still_ = sample.at_rest;
  if (!still_) standing_time_ = 0;
  const StepNoise noise = noise_of(sample);
  rate_variance_ = noise.gyro / sample.interval;
  ImuStep step = make_step(before_ ? &*before_ : nullptr, sample, after);
  const double begin = sample.time - sample.interval;
  if (state_.time > begin + kSameInstant) {  // the start stands within this sample
    if (state_.time >= sample.time - kSameInstant) return;
    step = split(step, state_.time - begin).second;
  }
  std::size_t done = 0;
  for (; done < queue_.size() && queue_[done].time <= sample.time + kSameInstant; ++done) {
    const Pending& pending = queue_[done];
    const double tau = pending.time - state_.time;
    if (tau <= kSameInstant) {
      measure(pending, step, 0);
    } else if (tau >= step.dt - kSameInstant) {
      // At the end of the step: nothing is left of it for the fixes that follow at the same instant.
      advance(step, noise);
      const ImuStep whole = step;
      for (; done < queue_.size() && queue_[done].time <= sample.time + kSameInstant; ++done) {
        measure(queue_[done], whole, whole.dt);
      }
      step.dt = 0;
      break;
    } else {
      const auto [first, second] = split(step, tau);
      advance(first, noise);
      step = second;
      measure(pending, step, 0);
    }
  }
  if (step.dt > 0) advance(step, noise);
  queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(done));
  state_.time = sample.time;  // not the sum of the steps: rounding must not pile up
  measure_rest(sample);
  if (tape_) tape_->events.emplace_back(Tape::Epoch{state_.time, state_.x, state_.P});
}

void Filter::advance(const ImuStep& step, const StepNoise& noise) {
  refresh_gravity();
  const ImuStep corrected = correct(step, state_.x);
  const Estimate before = state_.x;
  mechanize(state_.x, corrected, setup_->world.earth_rate(), gravity_);
  if (still_) stand(step.dt);
  Transition t = linearize(before, state_.x, corrected, setup_->world.earth_rate(), gravity_, noise,
                           still_ ? &standing_force_ : nullptr);
  add_processes(t, setup_->layout, setup_->options, step.dt);
  decay(state_.x, setup_->layout, t);
  propagate(state_.P, setup_->layout, t);
  state_.time += step.dt;
  if (!still_) gyro_noise_ += t.noise.block<3, 3>(6, 6);  // at rest no measured rate was regressed on
  if (tape_) tape_->events.emplace_back(Tape::Propagation{t});
}

// Before an attitude fix is used: the gyro's noise since the one before it, as the fix tells it, leaves the rate that
// the scale errors are regressed on.
void Filter::mend_rate_before(const Linearization& lin) {
  const bool recent = state_.time - mended_ < kMendable;
  mended_ = state_.time;
  const Matrix3d noise = std::exchange(gyro_noise_, Matrix3d::Zero());
  if (!recent || !setup_->layout.has(Block::kGyroScale)) return;
  const Update u = innovate(state_.P, setup_->layout, lin);
  if (!(u.nis <= setup_->gate[3])) return;
  const Matrix3d H = u.H.middleCols<3>(setup_->layout.offset(Block::kAttitude));
  const Transition t = mend_rate(state_.x, noise * H.transpose() * u.S_inverse * u.residual);
  propagate(state_.P, setup_->layout, t);
  if (tape_) tape_->events.emplace_back(Tape::Propagation{t});
}

// Gravity on the body's axes, the mean over the rest so far. The attitude of one epoch follows the noise of the
// accelerometers through the zero velocities; a scale regressed on it for minutes learns that noise.
void Filter::stand(double dt) {
  standing_time_ += dt;
  standing_force_ -= dt / standing_time_ * (state_.x.q_wb.conjugate() * gravity_.value + standing_force_);
}

void Filter::refresh_gravity() {
  if ((state_.x.p_wb - gravity_.point).squaredNorm() > kGravityReach * kGravityReach) {
    gravity_ = setup_->world.gravity(state_.x.p_wb);
  }
}

StepNoise Filter::noise_of(const ImuSample& sample) {
  const FilterOptions& o = setup_->options;
  const double gyro = o.sensor.gyro.noise, accel = o.sensor.accel.noise;
  StepNoise noise{Vector3d::Constant(gyro * gyro), Vector3d::Constant(accel * accel)};
  // What n clipped samples in a row hide is one error: its variance grows with n², by 2n − 1 a sample.
  const auto clip = [&](int axis, bool clipped, double range, double& density) {
    int& run = clipped_in_a_row_[static_cast<std::size_t>(axis)];
    run = clipped ? run + 1 : 0;
    const double hidden = kClippedSpread * range;
    if (clipped) density += hidden * hidden * sample.interval * (2 * run - 1);
  };
  for (int i = 0; i < 3; ++i) {
    clip(i, (sample.clipped_gyro >> i) & 1, o.sensor.gyro.range, noise.gyro(i));
    clip(3 + i, (sample.clipped_accel >> i) & 1, o.sensor.accel.range, noise.accel(i));
  }
  if (sample.gap) {
    trust_.suspect_filter(sample.time);
    noise.accel.array() += sample.gap->accel * sample.gap->accel;
    noise.gyro.array() += sample.gap->gyro * sample.gap->gyro;
  }
  return noise;
}

void Filter::measure(const Pending& pending, const ImuStep& step, double tau) {
  const FilterOptions& o = setup_->options;
  const Vector3d& earth_rate = setup_->world.earth_rate();
  if (const auto* fix = std::get_if<GnssFix>(&pending.fix)) {
    const bool repeated = trust_.repeats(pending.index, *fix);
    if (repeated && moves()) {
      innovations_.push_back({.time = state_.time,
                              .source = pending.source,
                              .residual = Vector3d::Zero(),
                              .sigma = Vector3d::Zero(),
                              .outcome = Outcome::kRepeated});
      return;
    }
    const GnssOptions& receiver = o.gnss[static_cast<std::size_t>(pending.index)];
    Estimate& x = state_.x;
    if (!setup_->layout.has(Block::kLeverArm)) x.lever_arm = receiver.lever_arm;
    // Rate and force at the fix: the line of the step, at tau from its start.
    const auto motion = [&] {
      const ImuStep s = correct(step, x);
      const double from_middle = tau - 0.5 * s.dt;
      return BodyMotion{s.mean_rate() + from_middle * s.rate_slope, s.mean_force() + from_middle * s.force_slope,
                        rate_variance_};
    };
    if (receiver.use_position) {
      apply(pending.source, linearize_position(*fix, receiver.drift, x, motion(), earth_rate, gravity_));
    }
    if (receiver.use_velocity && fix->velocity) {
      apply(pending.source + 1, linearize_velocity(*fix, x, motion(), earth_rate, gravity_, still_));
    }
  } else if (const auto* attitude = std::get_if<AttitudeFix>(&pending.fix)) {
    const AttitudeOptions& reference = o.attitude[static_cast<std::size_t>(pending.index)];
    const Vector3d white = reference.drift ? reference.white : Vector3d::Ones();
    const Linearization lin = linearize_attitude(*attitude, white, state_.x);
    mend_rate_before(lin);
    const Update u = innovate(state_.P, setup_->layout, lin);
    const Estimate after = boxplus(state_.x, setup_->layout, gain(u) * u.residual);
    const bool accepted = u.nis <= setup_->gate[3];
    apply(pending.source, accepted ? linearize_attitude(*attitude, white, state_.x, &after) : lin);
  } else if (const auto* heading = std::get_if<HeadingFix>(&pending.fix)) {
    apply(pending.source, linearize_heading(*heading, state_.x));
  } else if (const auto* magnetic = std::get_if<MagneticSample>(&pending.fix)) {
    apply(pending.source, linearize_magnetic_heading(magnetic->field, o.declination, o.magnetic_sigma, state_.x));
  }
}

void Filter::measure_rest(const ImuSample& sample) {
  if (!sample.at_rest || sample.gap) {
    rest_turn_.setZero();
    rest_time_ = 0;
    return;
  }
  rest_turn_ += sample.dtheta;
  rest_time_ += sample.interval;
  const FilterOptions& o = setup_->options;
  if (rest_time_ < o.rest.interval - 0.5 * sample.interval) return;
  apply(setup_->rest, linearize_zero_velocity(o.rest, state_.x));
  apply(setup_->rest + 1, linearize_zero_rate(o.rest, rest_turn_ / rest_time_, rest_time_, o.sensor.gyro.noise,
                                              state_.x, setup_->world.earth_rate()));
  rest_turn_.setZero();
  rest_time_ = 0;
}

// Adds to the navigation covariance what would explain the residual: an error of position grows out of one of velocity
// over the time since the last fix was believed, and that out of a tilt; where none ever was, it is the start's own.
void Filter::admit_error(const Linearization& lin, double lapse) {
  const double size = lin.residual.head(lin.rows).norm();
  double position = 0, velocity = 0, attitude = 0;
  switch (lin.observes) {
    case Block::kPosition:
      position = size;
      velocity = size / lapse;
      attitude = 2 * size / (kStandardGravity * lapse * lapse);
      break;
    case Block::kVelocity:
      velocity = size;
      attitude = size / (kStandardGravity * lapse);
      break;
    default:
      attitude = size;
  }
  attitude = std::min(attitude, kLargestTilt);
  const auto add = [&](Block b, double sigma) {
    state_.P.diagonal().segment<3>(setup_->layout.offset(b)).array() += sigma * sigma;
  };
  add(Block::kPosition, position);
  add(Block::kVelocity, velocity);
  add(Block::kAttitude, attitude);
}

// Whether the body moves for certain.
bool Filter::moves() const {
  return !still_ && state_.x.v_wb.norm() > 3 * sigmas_of(state_.x, setup_->layout, state_.P).velocity.norm();
}

void Filter::apply(int source, const Linearization& lin) {
  Update u = innovate(state_.P, setup_->layout, lin);
  if (!std::isfinite(u.nis)) {
    throw DataError(fmt::format("t = {:.3f} s", state_.time),
                    fmt::format("the filter diverged at {}: check units, axes and time stamps of the logs",
                                setup_->sources[static_cast<std::size_t>(source)]));
  }
  const double bound = setup_->gate[static_cast<std::size_t>(lin.rows)];
  const auto [outcome, lapse, parted] = trust_.rule(source, state_.time, lin, u, bound, state_.x, state_.P);
  innovations_.push_back(
      {state_.time, source, lin.rows, u.residual, u.S.diagonal().cwiseSqrt(), u.nis, bound, outcome});
  if (!was_used(outcome)) return;
  if (parted) {
    // Nothing that led to it explains the disagreement: the fix says where the body is from here on, and the rest of
    // the state is not to follow a residual of many sigmas.
    admit_error(lin, lapse);
    u = innovate(state_.P, setup_->layout, lin);
  }
  const FullError correction = expand(setup_->layout, gain(u) * u.residual);
  const ResetJacobian G = reset_jacobian(correction);
  joseph(state_.P, u, lin.covariance);
  reset(state_.P, setup_->layout, G);
  state_.x = boxplus(state_.x, correction);
  if (tape_) tape_->events.emplace_back(Tape::Correction{u, G});
  if (outcome == Outcome::kReadmitted && !parted) {
    // It is the filter that was wrong. The fix was taken with the covariance as it stood, so that filter and smoother
    // spread its residual over what led to it; what the filter missed is admitted afterwards.
    admit_error(lin, lapse);
  }
}

namespace {

// Walks a log in the order of time, one IMU sample a call, fixes before the sample that lets their step be processed.
class Feeder {
 public:
  Feeder(const Log& log, Checkpoint& c) : log_(log), c_(c) {}

  bool done() const { return c_.imu >= c_.imu_end; }

  // Returns true when an epoch was completed.
  bool step() {
    const ImuSample& sample = log_.imu[c_.imu++];
    for (std::size_t r = 0; r < log_.gnss.size(); ++r) feed(log_.gnss[r], c_.gnss[r], sample.time, static_cast<int>(r));
    for (std::size_t r = 0; r < log_.attitude.size(); ++r) {
      feed(log_.attitude[r], c_.attitude[r], sample.time, static_cast<int>(r));
    }
    for (; c_.magnetic < log_.magnetic.size() && log_.magnetic[c_.magnetic].time <= sample.time; ++c_.magnetic) {
      c_.filter.add(log_.magnetic[c_.magnetic]);
    }
    return c_.filter.add(sample);
  }

 private:
  template <class Fix>
  void feed(const std::vector<Fix>& fixes, std::size_t& next, double until, int source) {
    for (; next < fixes.size() && fixes[next].time <= until; ++next) c_.filter.add(source, fixes[next]);
  }

  const Log& log_;
  Checkpoint& c_;
};

template <class Samples>
std::size_t first_from(const Samples& samples, double time) {
  return static_cast<std::size_t>(
      std::partition_point(samples.begin(), samples.end(), [time](const auto& s) { return s.time < time; }) -
      samples.begin());
}

Checkpoint begin_at(const Log& log, Filter filter, double time, double end_time) {
  Checkpoint c{std::move(filter),
               first_from(log.imu, time + kSameInstant),
               first_from(log.imu, end_time),
               0,
               {},
               {},
               first_from(log.magnetic, time)};
  for (const auto& fixes : log.gnss) c.gnss.push_back(first_from(fixes, time - kSameInstant));
  for (const auto& fixes : log.attitude) c.attitude.push_back(first_from(fixes, time - kSameInstant));
  return c;
}

}  // namespace

FilterRun run_filter(const Log& log, const FilterOptions& options, const Start& start, int checkpoint_every,
                     const ProgressCallback& progress, double end_time) {
  Checkpoint c = begin_at(log, Filter(options, log.world, start), start.time, end_time);
  FilterRun run;
  run.solution = Solution(c.filter.layout(), log.world);
  run.solution.sources = c.filter.sources();
  run.solution.fixed = start.x;
  run.solution.reserve(c.imu_end - std::min(c.imu, c.imu_end));
  Feeder feeder(log, c);
  const auto take_epoch = [&] {
    Solution& s = run.solution;
    s.append(c.filter.time(), c.filter.estimate(),
             sigmas_of(c.filter.estimate(), c.filter.layout(), c.filter.covariance()));
    s.innovations.insert(s.innovations.end(), c.filter.innovations().begin(), c.filter.innovations().end());
    c.filter.clear_innovations();
    ++c.row;
  };
  if (checkpoint_every > 0) run.checkpoints.push_back(c);
  while (!feeder.done()) {
    if (!feeder.step()) continue;
    take_epoch();
    if (checkpoint_every > 0 && c.row % static_cast<std::size_t>(checkpoint_every) == 0) run.checkpoints.push_back(c);
    if (progress && c.row % 1000 == 0) progress(static_cast<double>(c.imu) / static_cast<double>(c.imu_end));
  }
  if (c.filter.finish()) take_epoch();
  run.solution.gnss_late = c.filter.late();
  return run;
}

void rerun(const Log& log, const Checkpoint& from, std::size_t end_row, Tape& tape) {
  Checkpoint c = from;
  c.filter.record(&tape);
  Feeder feeder(log, c);
  while (c.row < end_row) {
    const bool epoch = feeder.done() ? c.filter.finish() : feeder.step();
    if (epoch) {
      c.filter.clear_innovations();
      ++c.row;
    } else if (feeder.done()) {
      break;
    }
  }
}

}  // namespace piste
