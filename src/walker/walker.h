#pragma once
/// The walk over a log. IMU samples and fixes are added as they come; steps and measurements are given in the order of
/// time. The filter (filter.h) and the batch (batch.h) listen to the same walk, so that both process the same
/// measurements at the same times.
///
///     fixes → FixQueue, by time less delay ──────────┐
///     IMU samples → steps, split at times of fixes ──┴→ advance, measure, …, arrive, measure, …  (per sample)
///     ZUPT, ZARU, other pseudo-measurements ──────────→ measure, at the end of the sample
///
/// The walk is one sample behind the newest. It waits for the sample after a step, because both neighbours give the
/// slope of rate and force within the step. With this slope a step is split at the time of a fix without extrapolation.
///
/// For example, samples end at 0.01 s and 0.02 s, and a receiver with a delay of 5 ms gives a fix with the time 0.02 s.
/// Once the sample after 0.02 s is added, the listener gets: arrive (at 0.01 s); advance (to 0.015 s), measure, arrive
/// (at 0.02 s).

#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/time_search.h"
#include "model/imu_scales.h"
#include "piste/model/rate_regression.h"
#include "walker/fix_queue.h"
#include "walker/rest_updates.h"
#include "walker/sample_noise.h"
#include "walker/truncation.h"

namespace piste {

/// The place of a fix among the steps.
struct Moment {
  const ImuStep& step;   ///< as measured; the fix is within it
  double into_step = 0;  ///< time of the fix after the start of the step [s]
  double lag = 0;        ///< s by which the time of validity is before that, as the fix was added too late
  double delay = 0;      ///< of its source, as known when the fix was given its place [s]
};

/// The functions that a walk requires of its listener, and those that it calls.
template <class Listener>
concept WalkListener = requires(Listener& to, const Listener& known, const StepNoise& stated, const ImuStep& step,
                                const QueuedFix& fix, const RestFix& rest, const Moment& at) {
  { known.time() } -> std::convertible_to<double>;               // of the current state
  { known.estimate() } -> std::convertible_to<const Estimate&>;  // at that time; its delays place the fixes
  {
    known.imu_scales()
    } -> std::convertible_to<const ImuScales*>;  // of several IMUs whose scales act across axes; or null
  { known.resting() } -> std::same_as<bool>;     // whether it treats the body as stationary in this sample
  { known.takes(fix.source, fix.time) } -> std::same_as<bool>;  // whether it uses a fix
  {
    to.begin_sample(stated)
    } -> std::convertible_to<StepNoise>;  // returns the noise to use in place of the stated noise
  to.begin_step(step);                    // the sample, or its part after the start of the walk
  to.advance(step);                       // to the time of a fix within the sample
  to.arrive(step);                        // to the end of the sample
  to.measure(fix, at);
  // A pseudo-measurement, such as a ZUPT. Returns false if it was rejected.
  { to.template measure<ZeroUpdates>(rest, fix, at) } -> std::same_as<bool>;
  to.end_sample();
};

/// Walks a log. A copy has the whole state. No heap once the walk has begun.
class Walker {
 public:
  /// Empty, to be assigned to.
  Walker() = default;
  /// `x`: the estimate at the time `start`, where the walk begins. @pre `options` are valid.
  Walker(const FilterOptions& options, StateLayout layout, double start, const Estimate& x);

  /// Adds the next sample, and walks over the previous one. Returns whether there was one. Throws DataError if it is
  /// not finite, if its interval is not positive, or if it is not later than the previous one. The walk is then as it
  /// was before.
  template <WalkListener Listener>
  bool add(const ImuSample& sample, Listener& to) {
    check(sample);
    const bool walks = now_.has_value();
    if (walks) walk(&sample, to);
    before_ = std::exchange(now_, sample);
    return walks;
  }
  /// Adds a fix, in any order of time. `sensor` counts from 0 among the sensors of its type. A fix older than the time
  /// of the listener is left out and counted. A fix of a type that the options do not use is left out without a count.
  template <WalkListener Listener>
  void add(int sensor, const AnyFix& fix, const Listener& to) {
    MeasurementList::visit(
        [&]<class Type>(const typename Type::Fix& known) {
          if (!Type::in_use(options())) return;
          if (known.time < to.time() - kSameInstant) {
            ++late_;
            return;
          }
          const int first = sources().first<Type>(sensor);
          for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
            if (!to.takes(first + channel, known.time)) continue;
            queue_.add({known.time, first + channel, sensor, channel, fix});
          }
        },
        fix);
  }
  /// Walks over the last sample. Returns false if there is none.
  template <WalkListener Listener>
  bool finish(Listener& to) {
    if (!now_) return false;
    walk(nullptr, to);
    now_.reset();
    return true;
  }

  const FilterOptions& options() const { return setup_->options; }
  const StateLayout& layout() const { return setup_->layout; }
  const MeasurementSources& sources() const { return setup_->sources; }
  double start() const { return setup_->start; }
  /// How far ahead of the samples fixes must be added so that each is used at its time of validity [s].
  double look_ahead() const { return setup_->look_ahead; }
  /// Time since which the drift of the IMU's clock counts [s].
  double elapsed(double time) const { return time - setup_->clock_from; }
  /// Whether a delay is estimated. Then find_delays() must be called when a logged fix has changed the estimate.
  bool delays_change() const { return setup_->delays_change; }
  void find_delays(double time, const Estimate& x) {
    setup_->sources.find_delays(options(), layout(), x, elapsed(time), delays_);
  }
  /// Number of fixes that were left out because they came too late.
  std::size_t late() const { return late_; }

  /// The sample that is being processed, or is next. @pre There is one.
  const ImuSample& sample() const { return *now_; }
  bool has_sample() const { return now_.has_value(); }
  /// This sample as a step, as if the mean of several IMUs had only its own scales. `after`: the sample after it, or
  /// null.
  ImuStep step(const ImuSample* after, const ImuScales* imu_scales, const Estimate& x) const;
  const StepNoise& noise() const { return noise_; }
  /// Variance of the gyroscopes' white noise in the mean rate of the sample.
  const Vector3d& rate_variance() const { return rate_variance_; }
  /// Mean rate of the previous and the next sample.
  const Vector3d& neighbour_rate() const { return neighbour_rate_; }
  /// Regression of the rate of a sample on neighbour_rate(), fitted to the samples so far.
  const RateRegression& rate_regression() const { return rate_regression_; }
  /// Whether the body is stationary: standstill was detected, and not withdrawn after rejected updates.
  bool at_rest() const { return now_->at_rest && !rest_.withdrawn(); }

 private:
  struct Setup {  // constant over the run; shared between copies
    FilterOptions options;
    StateLayout layout;
    MeasurementSources sources;
    bool delays_change = false;
    double look_ahead = 0, start = 0, clock_from = 0;
  };
  void check(const ImuSample& sample) const;

  template <class Listener>
  void walk(const ImuSample* after, Listener& to) {
    const ImuSample& sample = *now_;
    const ClippedNoise own = sample_noise_.of(sample, options().sensor);
    noise_ = to.begin_sample(own.noise);
    rate_variance_ = noise_.gyro / sample.interval;
    const StepNoise truncated = truncation_.add(after, options().sensor);
    noise_.gyro += truncated.gyro;
    noise_.accel += truncated.accel;
    neighbour_rate_ = piste::neighbour_rate(before_ ? &*before_ : nullptr, sample, after);
    ImuStep whole = step(after, to.imu_scales(), to.estimate());
    whole.dtheta += own.hidden_rate * sample.interval;
    whole.dvel += own.hidden_force * sample.interval;
    const double begin = sample.time - sample.interval;
    if (to.time() > begin + kSameInstant) {  // the start is within this sample
      if (to.time() >= sample.time - kSameInstant) return;
      whole = split(whole, to.time() - begin).second;
    }
    to.begin_step(whole);
    if (layout().has(Block::kClockDrift)) find_delays(to.time(), to.estimate());
    const ImuStep last = walk_to_end(whole, to);
    if (const std::optional<RestFix> fix = rest_.add(sample, options().behaviour.rest)) {
      rest_.judge(measure<ZeroUpdates>(*fix, last, to), options().behaviour.rest);
    }
    measure_made(last, to);
    if (!to.resting()) rate_regression_.add(sample, neighbour_rate_, to.estimate());
    to.end_sample();
  }

  // Walks from fix to fix. Returns the last part of the step.
  template <class Listener>
  ImuStep walk_to_end(ImuStep step, Listener& to) {
    bool at_end = false;
    while (const std::optional<QueuedFix> fix = queue_.take(now_->time, delays_)) {
      const double delay = delays_[static_cast<std::size_t>(fix->source)];
      const double into_step = fix->time - delay - to.time(), lag = into_step < -kSameInstant ? -into_step : 0;
      const bool later = !at_end && into_step > kSameInstant;
      if (later && into_step >= step.dt - kSameInstant) {
        to.arrive(step);
        at_end = true;
      } else if (later) {
        const auto [first, second] = split(step, into_step);
        to.advance(first);
        step = second;
      }
      to.measure(*fix, {step, at_end ? step.dt : 0, lag, delay});
    }
    if (!at_end) to.arrive(step);
    return step;
  }

  // Measures all channels of a pseudo-measurement at the end of the step. Returns whether none was rejected.
  template <class Type, class Listener>
  bool measure(const typename Type::Fix& fix, const ImuStep& step, Listener& to) {
    bool used = true;
    for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
      const QueuedFix place{fix.time, sources().first<Type>(0) + channel, 0, channel, fix};
      if (!to.takes(place.source, place.time)) continue;
      used = to.template measure<Type>(fix, place, {step, step.dt, 0, 0}) && used;
    }
    return used;
  }

  // Makes the pseudo-measurements that are due at the end of the sample: a multiple of the interval of their type has
  // passed in it. None is due in a gap.
  template <class Listener>
  void measure_made(const ImuStep& step, Listener& to) {
    const ImuSample& sample = *now_;
    if (sample.gap) return;
    const double begin = sample.time - sample.interval;
    MeasurementList::for_each([&]<class Type>() {
      const std::optional<double> every = Type::interval(options());
      if (!every || std::floor(sample.time / *every) == std::floor(begin / *every)) return;
      typename Type::Fix fix{};
      fix.time = sample.time;
      measure<Type>(fix, step, to);
    });
  }

  std::shared_ptr<const Setup> setup_;
  std::optional<ImuSample> before_, now_;
  FixQueue queue_;
  std::vector<double> delays_;  // of the sources, by the current estimate
  SampleNoise sample_noise_;
  Truncation truncation_;
  StepNoise noise_;
  Vector3d rate_variance_ = Vector3d::Zero(), neighbour_rate_ = Vector3d::Zero();
  RateRegression rate_regression_;
  RestUpdates rest_;
  std::size_t late_ = 0;
};

}  // namespace piste
