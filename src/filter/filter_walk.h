#pragma once
// The filter as a listener of the walk, and the recorder of its operations.

#include <algorithm>
#include <optional>
#include <utility>

#include "core/time_search.h"
#include "filter/kalman_filter.h"

namespace piste {

/// Records nothing. The functions are those of every recorder; History (history.h) documents their arguments.
struct Unrecorded {
  static void add_step(const Transition&) {}
  static void add_correction(const Update&) {}
  static void add_correction(const Update&, const ResetJacobian&, const Estimate&, const std::optional<Standing>&) {}
  static void add_score_correction(const ScaleScore&, const ErrorVector&, bool) {}
  static void add_inflation(const ErrorVector&) {}
  static void add_moved(const ErrorVector&) {}
  static void end_row(const FilterState&) {}
};
inline constexpr Unrecorded kUnrecorded;

/// Walks a filter over a log, and records each operation of the filter, in order. Samples and fixes are added as to the
/// filter itself, with the same result.
template <class Recorder>
class FilterWalk {
 public:
  FilterWalk(KalmanFilter& filter, Recorder& recorder) : f_(filter), recorder_(recorder) {}

  bool add(const ImuSample& sample) { return f_.walker_.add(sample, *this); }
  void add(int sensor, const AnyFix& fix) { f_.walker_.add(sensor, fix, *this); }
  bool finish() { return f_.walker_.finish(*this); }
  double look_ahead() const { return f_.look_ahead(); }

  // The calls of the walk (walker.h).
  double time() const { return f_.state_.time; }
  const Estimate& estimate() const { return f_.state_.x; }
  const ImuScales* imu_scales() const { return f_.imu_scales_.get(); }
  bool resting() const { return f_.resting(); }
  bool takes(int, double) const { return true; }

  StepNoise begin_sample(const StepNoise& stated) {
    if (f_.walker_.sample().gap) f_.fault_detection_.suspect_filter(f_.walker_.sample().time);
    return f_.adaptation_.of(stated);
  }

  void begin_step(const ImuStep& step) {
    if (!f_.reference_) return;
    if (f_.reference_->ends_before(f_.walker_.sample().time - kSameInstant)) {
      recorder_.add_moved(f_.leave_reference());
    } else {
      f_.follow_reference(step.dt);
    }
  }

  void advance(const ImuStep& step) {
    correct_score();
    const StepNoise& noise = f_.walker_.noise();
    const Transition t = f_.predict(step, noise);
    f_.mending_.add(t, resting());
    f_.adaptation_.propagate(f_.layout(), t, noise, step.dt);
    const auto [gyro, accel] = f_.adaptation_.imu_variances();
    if (!resting() && f_.reference_) f_.errors_in_variables_.add_smoothed(step.dt);
    if (!resting() && !f_.reference_) f_.errors_in_variables_.add(step.dt, gyro, accel);
    recorder_.add_step(t);
  }

  void arrive(const ImuStep& step) {
    advance(step);
    f_.state_.time = f_.walker_.sample().time;  // not the sum of the steps, so that rounding errors do not add up
    if (f_.reference_) recorder_.add_moved(f_.arrive_at_reference());
  }

  void measure(const QueuedFix& fix, const Moment& at) {
    MeasurementList::visit([&]<class Type>(const typename Type::Fix& known) { measure<Type>(known, fix, at); },
                           fix.fix);
    if (f_.walker_.delays_change()) f_.find_delays();
  }

  /// Returns false if the fix was rejected.
  template <class Type>
  bool measure(const typename Type::Fix& fix, const QueuedFix& place, const Moment& at) {
    const FilterState& now = f_.state_;
    if (f_.fault_detection_.template repeats<Type>(place.source, fix) && f_.moves()) {
      // Reported once for the whole fix.
      if (place.channel > 0) return true;
      f_.innovations_.push_back({.time = now.time,
                                 .source = place.source,
                                 .residual = Vector3d::Zero(),
                                 .sigma = Vector3d::Zero(),
                                 .outcome = Outcome::kRepeated,
                                 .late = place.time - now.time});
      return false;
    }
    if constexpr (requires { fix.slow_change; }) {
      if (place.channel == 0) change_slow_error(place.sensor, fix.slow_change);
    }
    const Walker& walker = f_.walker_;
    const double elapsed = walker.elapsed(now.time);
    const FixDelay delay = Type::delay(f_.options(), f_.layout(), place.sensor, place.channel, now.x, elapsed);
    // A fix from before the start is already in the initial state, and the motion back to that fix is not known.
    if (at.lag > 0 && place.time - delay.value < walker.start() - kSameInstant) return true;
    const MeasurementContext context{.options = f_.options(),
                                     .layout = f_.layout(),
                                     .earth_rate = f_.world().earth_rate(),
                                     .gravity = f_.gravity_,
                                     .step = at.step,
                                     .into_step = at.into_step,
                                     .rate_variance = walker.rate_variance(),
                                     .still = resting(),
                                     .elapsed = elapsed,
                                     .moved = delay.value - at.lag,
                                     .recent = f_.motion_.at(now.x.q_wb, f_.options().sensor),
                                     .steps = &f_.steps_,
                                     // About a reference, the uncertainty of the delay is part of the linear problem.
                                     .delay_variance = f_.reference_ ? 0 : f_.variance_of(delay),
                                     .neighbour_rate = walker.neighbour_rate(),
                                     .rate_regression = &walker.rate_regression()};
    std::optional<Linearization> lin = Type::linearize(fix, place.sensor, place.channel, context, now.x);
    if (!lin) return true;
    // At standstill the covariance describes the sway of the body. The factor estimated in motion does not apply to it.
    const double factor = f_.adaptation_.variance_of(place.source),
                 learned = resting() ? std::max(1.0, factor) : factor;
    lin->covariance *= learned;
    if (f_.reference_) {
      lin->residual -= assemble(f_.layout(), *lin) * now.mean;
      return use(place, *lin);
    }
    if constexpr (requires { Type::linearize(fix, 0, 0, context, now.x, &now.x); }) {
      return use(place, half_way<Type>(fix, place, context, *lin, learned));
    } else {
      return use(place, *lin);
    }
  }

  void end_sample() { recorder_.end_row(f_.state_); }

 private:
  // For a fix that depends on several rotations: linearises half-way between the estimates before and after the fix.
  template <class Type>
  Linearization half_way(const typename Type::Fix& fix, const QueuedFix& place, const MeasurementContext& context,
                         const Linearization& at_estimate, double learned) {
    const FilterState& now = f_.state_;
    const double bound = f_.gate(at_estimate);
    if (const auto mending = f_.mending_.before(at_estimate, now, f_.layout(), bound)) mend(*mending);
    const Update u = innovate(now.P, f_.layout(), at_estimate);
    if (!(u.nis <= bound)) return at_estimate;
    const Estimate after = boxplus(now.x, f_.layout(), gain(u) * u.residual);
    Linearization between = *Type::linearize(fix, place.sensor, place.channel, context, now.x, &after);
    between.covariance *= learned;
    return between;
  }

  // The slow error of a receiver, in units of its size, after that has changed.
  void change_slow_error(int receiver, const Vector3d& change) {
    if (change.isZero(0)) return;
    if (const std::optional<ErrorVector> added = f_.change_slow_error(receiver, change))
      recorder_.add_inflation(*added);
  }

  // Tests a fix, and uses it unless it is excluded. Returns whether it was used.
  bool use(const QueuedFix& place, const Linearization& lin) {
    const auto [u, ruling] = f_.test(place.source, place.time - time(), lin);
    if (!was_used(ruling.outcome)) return false;
    // No error of the past explains a sudden disagreement. The covariance is then inflated first: the fix moves the
    // navigation states, and the other states do not follow a residual of many sigmas.
    if (ruling.parted) {
      recorder_.add_inflation(f_.inflate(lin, ruling.lapse));
      f_.errors_in_variables_.covariance_changed();
    }
    correct(ruling.parted ? innovate(f_.state_.P, f_.layout(), lin) : u, lin);
    // In other cases of a filter at fault, the fix is used with the covariance as it is. Filter and smoother then
    // attribute the residual to the errors that led to it. The covariance is inflated afterwards.
    const bool grows = !ruling.parted && ruling.outcome == Outcome::kReadmitted;
    if (grows) recorder_.add_inflation(f_.inflate(lin, ruling.lapse));
    return true;
  }

  void correct(const Update& u, const Linearization& lin) {
    const FilterState& now = f_.state_;
    f_.errors_in_variables_.observe(now.x, now.P, f_.gravity_.value, u, lin, f_.adaptation_.imu_variances()[0],
                                    f_.has_reference());
    const Estimate before = now.x;
    const std::optional<Standing> standing = f_.standing();
    const ResetJacobian G = f_.reset(f_.update(u), standing);
    f_.adaptation_.correct(f_.layout(), u, G);
    if (!(now.P.diagonal().minCoeff() >= 0)) f_.fail("to a negative variance");
    if (f_.reference_) {
      recorder_.add_correction(u);
    } else {
      recorder_.add_correction(u, G, before, standing);
    }
  }

  void mend(Transition transition) {
    transition.imu_scales = f_.imu_scales_.get();
    propagate(f_.state_.P, f_.layout(), transition);
    f_.adaptation_.propagate(f_.layout(), transition, {Vector3d::Zero(), Vector3d::Zero()}, 0);
    recorder_.add_step(transition);
  }

  // Errors-in-variables correction of the scales for the fixes since the last one.
  void correct_score() {
    FilterState& now = f_.state_;
    const auto of_noise = f_.errors_in_variables_.after_fixes(now.x);
    if (!of_noise) return;
    for (const auto& [information, scales] :
         {std::pair<Vector3d, Block>{of_noise->information.head<3>(), Block::kGyroScale},
          {of_noise->information.tail<3>(), Block::kAccelScale}}) {
      const std::optional<Update> u = f_.remove_information(information, scales);
      if (!u) continue;
      f_.adaptation_.correct(f_.layout(), *u, reset_jacobian(FullError::Zero()));
      recorder_.add_correction(*u);
    }
    const ErrorVector moved = -pull_of(of_noise->score, f_.layout(), now.P);
    if (f_.reference_) {
      now.mean += moved;
    } else {
      now.x = boxplus(now.x, f_.layout(), moved);
    }
    recorder_.add_score_correction(of_noise->score, moved, !f_.reference_);
  }

  KalmanFilter& f_;
  Recorder& recorder_;
};

}  // namespace piste
