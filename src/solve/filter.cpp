#include "piste/solve/filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "made_fixes.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "solve/readmission.h"

namespace piste {
namespace {

// What delays hang on.
constexpr std::array kDelayBlocks{Block::kGnssDelay, Block::kVelocityDelay, Block::kAttitudeDelay, Block::kClockDrift};

// s by which an estimated delay may grow beyond the known one before its fixes come after the samples.
constexpr double kRoomToGrow = 1;

double longest_delay(const FilterOptions& options) {
  double longest = 0;
  for (const GnssOptions& g : options.gnss) longest = std::max({longest, g.delay, g.delay_of_velocity()});
  for (const AttitudeOptions& a : options.attitude) longest = std::max(longest, a.delay);
  return longest > 0 ? longest + kSameInstant : 0;
}

}  // namespace

Filter::Filter(const FilterOptions& options, const World& world, const Start& start,
               std::shared_ptr<const Reference> reference) {
  options.validate();
  auto setup = std::make_shared<Setup>();
  setup->options = options;
  setup->layout = StateLayout(options.estimate);
  setup->world = world;
  for (int n = 1; n <= 3; ++n)
    setup->gate[static_cast<std::size_t>(n)] = chi_squared_quantile(options.behaviour.trust.gate, n);
  setup->sources = MeasurementSources(options);
  setup->names = setup->sources.names();
  const StateLayout& layout = setup->layout;
  setup->delays_change =
      std::any_of(kDelayBlocks.begin(), kDelayBlocks.end(), [&](Block delay) { return layout.has(delay); });
  setup->look_ahead = longest_delay(options) + (setup->delays_change ? kRoomToGrow : 0);
  delays_.assign(setup->names.size(), 0);
  trust_ = Trust(setup->sources.all(), options.behaviour.trust);
  setup->begin = start.time;
  setup->clock_from = options.clock_from.value_or(start.time);
  state_ = {start.time, start.x, initial_covariance(setup->layout, options, start)};
  state_.mean.setZero(setup->layout.size());
  noise_score_ = NoiseScore(options, setup->layout);
  adaptation_ = Adaptation(options, setup->layout, setup->sources);
  if (reference) {
    state_.x = reference->start;
    state_.mean = boxminus(start.x, state_.x, setup->layout);
    reference_.emplace(std::move(reference));
  }
  propagation_ = Propagation(world, start.x.p_wb, options);
  innovations_.reserve(256);
  setup_ = std::move(setup);
  find_delays();
}

void Filter::add(int sensor, AnyFix fix) {
  MeasurementList::visit(
      [&]<class Type>(const typename Type::Fix& known) {
        if (!Type::in_use(setup_->options)) return;
        if (known.time < state_.time - kSameInstant) {
          ++late_;
          return;
        }
        const int first = setup_->sources.first<Type>(sensor);
        for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
          queue_.add({known.time, first + channel, sensor, channel, fix});
        }
      },
      fix);
}

bool Filter::add(const ImuSample& sample) {
  const bool later = std::isfinite(sample.time) && (!now_ || sample.time > now_->time);
  if (!later || !(sample.interval > 0) || !sample.dtheta.allFinite() || !sample.dvel.allFinite()) {
    throw DataError(fmt::format("t = {:.6f} s", sample.time),
                    "a sample must be finite, of an interval above zero, and later than the one before it");
  }
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
    const ImuStep step = correct(step_of(nullptr), x);
    mechanize(x, step, setup_->world.earth_rate(), propagation_.gravity());
  }
  return x;
}

// Of the sample that is processed, as the mean's own scales alone would have it.
ImuStep Filter::step_of(const ImuSample* after) const {
  return without_rest(propagation_.units(), make_step(before_ ? &*before_ : nullptr, *now_, after), state_.x);
}

void Filter::process(const ImuSample* after) {
  const ImuSample& sample = *now_;
  const StepNoise noise = adaptation_.of(sample_noise_.of(sample, setup_->options.sensor));
  rate_variance_ = noise.gyro / sample.interval;
  rate_beside_ = rate_beside(before_ ? &*before_ : nullptr, sample, after);
  if (sample.gap) trust_.suspect_filter(sample.time);
  ImuStep step = step_of(after);
  const double begin = sample.time - sample.interval;
  if (state_.time > begin + kSameInstant) {  // the start is within this sample
    if (state_.time >= sample.time - kSameInstant) return;
    step = split(step, state_.time - begin).second;
  }
  if (reference_ && reference_->ends_before(sample.time - kSameInstant)) leave_reference();
  if (reference_) follow_reference(step.dt);
  if (setup_->layout.has(Block::kClockDrift)) find_delays();
  bool at_end = false;
  while (const std::optional<QueuedFix> fix = queue_.take(sample.time, delays_)) {
    const double into_step = fix->time - delays_[static_cast<std::size_t>(fix->source)] - state_.time;
    const double lag = into_step < -kSameInstant ? -into_step : 0;
    if (at_end) {
      measure(*fix, step, step.dt, lag);
    } else if (into_step <= kSameInstant) {
      measure(*fix, step, 0, lag);
    } else if (into_step >= step.dt - kSameInstant) {
      advance(step, noise);
      arrive();
      at_end = true;
      measure(*fix, step, step.dt, 0);
    } else {
      const auto [first, second] = split(step, into_step);
      advance(first, noise);
      step = second;
      measure(*fix, step, 0, 0);
    }
  }
  if (!at_end) {
    advance(step, noise);
    arrive();
  }
  state_.time = sample.time;  // not the sum of the steps, so that rounding errors do not add up
  if (const std::optional<RestFix> fix = rest_.add(sample, setup_->options.behaviour.rest)) {
    const int first = setup_->sources.first<ZeroUpdates>(0);
    const std::size_t before = innovations_.size();
    for (int channel = 0; channel < static_cast<int>(ZeroUpdates::kChannels.size()); ++channel) {
      measure<ZeroUpdates>(*fix, {sample.time, first + channel, 0, channel, {}}, step, step.dt, 0);
    }
    rest_.judge(std::all_of(innovations_.begin() + static_cast<std::ptrdiff_t>(before), innovations_.end(),
                            [](const Innovation& i) { return was_used(i.outcome); }),
                setup_->options.behaviour.rest);
  }
  make_fixes(sample, setup_->options, [&]<class Type>(const typename Type::Fix& fix) {
    for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
      measure<Type>(fix, {fix.time, setup_->sources.first<Type>(0) + channel, 0, channel, {}}, step, step.dt, 0);
    }
  });
  if (!resting()) rate_regression_.add(sample, rate_beside_, state_.x);
  if (tape_) tape_->end_epoch(state_);
  if (history_) history_->end_row(state_);
}

void Filter::advance(const ImuStep& step, const StepNoise& noise) {
  take_back_noise();
  const Transition t = propagation_.advance(state_, step, noise, resting(), setup_->world, setup_->layout,
                                            setup_->options, reference_ ? &known_ : nullptr);
  mending_.add(t, resting());
  adaptation_.propagate(setup_->layout, t, noise, step.dt);
  if (!resting() && reference_) {
    noise_score_.add_smoothed(step.dt);
  } else if (!resting()) {
    const auto [gyro, accel] = adaptation_.imu_variances();
    noise_score_.add(step.dt, gyro, accel);
  }
  if (tape_) tape_->events.emplace_back(Tape::Propagation{t});
  if (history_) history_->add_step(t);
}

// Finds where the reference is at the end of the sample, and the motion to it.
void Filter::follow_reference(double dt) {
  target_ = reference_->at(now_->time).x;
  known_ = motion_between(state_.x, target_, dt, setup_->world.earth_rate(), propagation_.gravity());
}

// At the end of a sample: the estimate becomes that of the reference, and what the sample tells beside it is in the
// mean.
void Filter::arrive() {
  if (!reference_) return;
  const ErrorVector moved = boxminus(state_.x, target_, setup_->layout);
  state_.mean += moved;
  if (history_) history_->add_moved(moved);
  state_.x = target_;
}

// Where the reference ends: the estimate becomes what is known beside it, and the filter goes on about its own. The
// covariance stays, as the reference is a smoothed one and near.
void Filter::leave_reference() {
  if (history_) history_->add_moved(-state_.mean);
  state_.x = boxplus(state_.x, setup_->layout, state_.mean);
  state_.mean.setZero();
  reference_.reset();
  if (setup_->delays_change) find_delays();
}

// The delays of all sources by the estimate.
void Filter::find_delays() {
  setup_->sources.find_delays(setup_->options, setup_->layout, state_.x, elapsed(), delays_);
}

// Of its error.
double Filter::variance_of(const FixDelay& delay) const {
  const StateLayout& layout = setup_->layout;
  const int own = delay.block ? layout.offset(*delay.block) : -1;
  double variance = own < 0 ? 0 : state_.P(own, own);
  if (const double slope = delay.by_clock_drift; slope != 0) {
    const int drift = layout.offset(Block::kClockDrift);
    variance += slope * slope * state_.P(drift, drift) + (own < 0 ? 0 : 2 * slope * state_.P(own, drift));
  }
  return variance;
}

void Filter::measure(const QueuedFix& fix, const ImuStep& step, double into_step, double lag) {
  MeasurementList::visit(
      [&]<class Type>(const typename Type::Fix& known) { measure<Type>(known, fix, step, into_step, lag); }, fix.fix);
  if (setup_->delays_change) find_delays();
}

template <class Type>
void Filter::measure(const typename Type::Fix& fix, const QueuedFix& place, const ImuStep& step, double into_step,
                     double lag) {
  const int sensor = place.sensor, channel = place.channel, source = place.source;
  if (trust_.repeats<Type>(source, fix) && moves()) {
    // Said of the whole fix, once.
    if (channel > 0) return;
    innovations_.push_back({.time = state_.time,
                            .source = source,
                            .residual = Vector3d::Zero(),
                            .sigma = Vector3d::Zero(),
                            .outcome = Outcome::kRepeated,
                            .late = place.time - state_.time});
    return;
  }
  const FixDelay delay = Type::delay(setup_->options, setup_->layout, sensor, channel, state_.x, elapsed());
  // What belongs before the start has told the start already, and the motion back to it is not known.
  if (lag > 0 && place.time - delay.value < setup_->begin - kSameInstant) return;
  const MeasurementContext context{.options = setup_->options,
                                   .layout = setup_->layout,
                                   .earth_rate = setup_->world.earth_rate(),
                                   .gravity = propagation_.gravity(),
                                   .step = step,
                                   .into_step = into_step,
                                   .rate_variance = rate_variance_,
                                   .still = resting(),
                                   .elapsed = elapsed(),
                                   .moved = delay.value - lag,
                                   .recent = propagation_.recent(state_.x.q_wb, setup_->options.sensor),
                                   // About a reference the delay's uncertainty is part of the linear problem.
                                   .delay_variance = reference_ ? 0 : variance_of(delay),
                                   .rate_beside = rate_beside_,
                                   .rate_regression = &rate_regression_};
  std::optional<Linearization> lin = Type::linearize(fix, sensor, channel, context, state_.x);
  if (!lin) return;
  // At rest the covariance is that of the body's sway, of which what was learned under way says nothing.
  const double factor = adaptation_.variance_of(source), learned = resting() ? std::max(1.0, factor) : factor;
  lin->covariance *= learned;
  const double late = place.time - state_.time;
  if (reference_) {
    Linearization beside = *lin;
    beside.residual -= assemble(setup_->layout, beside) * state_.mean;
    apply(source, late, beside);
    return;
  }
  if constexpr (requires { Type::linearize(fix, sensor, channel, context, state_.x, &state_.x); }) {
    apply(source, late, half_way<Type>(fix, sensor, channel, context, *lin, learned));
  } else {
    apply(source, late, *lin);
  }
}

// For a fix that depends on several rotations: linearises half-way between the estimate before the fix and that after
// it.
template <class Type>
Linearization Filter::half_way(const typename Type::Fix& fix, int sensor, int channel,
                               const MeasurementContext& context, const Linearization& at_estimate, double learned) {
  const double bound = setup_->gate[static_cast<std::size_t>(at_estimate.rows)];
  if (const auto mending = mending_.before(at_estimate, state_, setup_->layout, bound)) propagate_by(*mending);
  const Update u = innovate(state_.P, setup_->layout, at_estimate);
  if (!(u.nis <= bound)) return at_estimate;
  const Estimate after = boxplus(state_.x, setup_->layout, gain(u) * u.residual);
  Linearization between = *Type::linearize(fix, sensor, channel, context, state_.x, &after);
  between.covariance *= learned;
  return between;
}

void Filter::propagate_by(Transition transition) {
  transition.units = propagation_.units();
  propagate(state_.P, setup_->layout, transition);
  adaptation_.propagate(setup_->layout, transition, {Vector3d::Zero(), Vector3d::Zero()}, 0);
  if (tape_) tape_->events.emplace_back(Tape::Propagation{transition});
  if (history_) history_->add_step(transition);
}

// Whether the body certainly moves.
bool Filter::moves() const {
  return !resting() &&
         state_.x.v_wb.norm() > 3 * sigmas_of(setup_->world, state_.x, setup_->layout, state_.P).velocity.norm();
}

void Filter::apply(int source, double late, const Linearization& lin) {
  const Update u = innovate(state_.P, setup_->layout, lin);
  if (!(u.nis >= 0) || !std::isfinite(u.nis)) {
    throw DataError(fmt::format("t = {:.3f} s", state_.time),
                    fmt::format("the filter diverged at {}: check units, axes and time stamps of the logs",
                                setup_->names[static_cast<std::size_t>(source)]));
  }
  const double bound = setup_->gate[static_cast<std::size_t>(lin.rows)];
  const auto [outcome, lapse, parted] = trust_.rule(source, state_.time, lin, u, bound, state_.x, state_.P);
  const Matrix3d shown = along_world(lin) ? propagation_.gravity().R_wn.transpose() : Matrix3d::Identity().eval();
  innovations_.push_back({.time = state_.time,
                          .source = source,
                          .dof = lin.rows,
                          .residual = shown * u.residual,
                          .sigma = (shown * u.S * shown.transpose()).diagonal().cwiseSqrt(),
                          .nis = u.nis,
                          .gate = bound,
                          .outcome = outcome,
                          .late = late,
                          .log_determinant = std::log(u.S.determinant())});
  if (!resting()) adaptation_.learn(source, state_.time, u, bound);
  if (!was_used(outcome)) return;
  if (parted) {
    // The disagreement came at once, and no error of the past explains it. The covariance grows first: the fix then
    // moves the navigation states, and the other states do not follow a residual of many sigmas.
    admit(lin, lapse);
    correct_by(innovate(state_.P, setup_->layout, lin), lin);
    return;
  }
  correct_by(u, lin);
  // The filter was wrong. The fix was used with the covariance as it was, so that filter and smoother attribute the
  // residual to the errors that led to it. The covariance grows afterwards.
  if (outcome == Outcome::kReadmitted) admit(lin, lapse);
}

void Filter::admit(const Linearization& lin, double lapse) {
  const ErrorVector before = state_.P.diagonal();
  admit_error(state_.P, setup_->layout, lin, lapse, setup_->options.behaviour.trust);
  if (history_) history_->add_admitted(state_.P.diagonal() - before);
}

void Filter::correct_by(const Update& u, const Linearization& lin) {
  noise_score_.before_fix(state_.x, state_.P);
  if (!resting()) noise_score_.swung(state_.x, u, lin, adaptation_.imu_variances()[0], reference_.has_value());
  const ErrorVector correction = gain(u) * u.residual;
  update(state_.P, u);
  ResetJacobian G = reset_jacobian(FullError::Zero());
  if (reference_) {
    state_.mean += correction;
    if (history_) history_->add_correction(u);
  } else {
    const Vector3d down = propagation_.gravity().value.normalized();
    // Beside a boresight that is estimated, a reference tells the attitude far better than rest tells tilt and bias.
    const bool stands = resting() && !setup_->layout.has(Block::kBoresight);
    G = carrying_jacobian(state_.x, setup_->layout, correction, down, stands);
    if (history_) history_->add_correction(u, state_.x, down, stands);
    reset(state_.P, setup_->layout, G);
    state_.x = corrected(state_.x, setup_->layout, correction, stands);
  }
  adaptation_.correct(setup_->layout, u, G);
  if (!(state_.P.diagonal().minCoeff() >= 0)) fail("its covariance has a negative variance");
  if (tape_) tape_->events.emplace_back(Tape::Correction{u, G});
}

// Takes back what the IMU's noise has told of the scales in the fixes of this instant.
void Filter::take_back_noise() {
  const auto told = noise_score_.after_fixes(state_.x, state_.P, propagation_.gravity().value);
  if (!told) return;
  take_information(told->information.head<3>(), Block::kGyroScale);
  take_information(told->information.tail<3>(), Block::kAccelScale);
  const ErrorVector moved = -pull_of(told->score, setup_->layout, state_.P);
  if (reference_) {
    state_.mean += moved;
  } else {
    state_.x = boxplus(state_.x, setup_->layout, moved);
  }
  if (tape_) tape_->events.emplace_back(Tape::TakenBack{told->score});
  if (history_) history_->add_taken_back(told->score, moved, !reference_);
}

void Filter::take_information(const Vector3d& information, Block scales) {
  if (!setup_->layout.has(scales)) return;
  // Not more than the fixes have told: what was known before them, noise does not take.
  const Vector3d before = info(scales).prior(setup_->options).cwiseAbs2();
  const Vector3d now = state_.P.diagonal().segment<3>(setup_->layout.offset(scales));
  const Vector3d told = (now.cwiseInverse() - before.cwiseInverse()).cwiseMax(0);
  const std::optional<Update> u = taking(information.cwiseMin(told), setup_->layout, scales, state_.P);
  if (!u) return;
  update(state_.P, *u);
  const ResetJacobian none = reset_jacobian(FullError::Zero());
  adaptation_.correct(setup_->layout, *u, none);
  if (tape_) tape_->events.emplace_back(Tape::Correction{*u, none});
  if (history_) history_->add_correction(*u);
}

void Filter::fail(const std::string& why) const {
  throw DataError(fmt::format("t = {:.3f} s", state_.time),
                  fmt::format("the filter diverged: {}; check units, axes and time stamps of the logs", why));
}

}  // namespace piste
