#include "batch_chain.h"

#include <cmath>
#include <optional>

#include "core/time_search.h"
#include "feeder.h"
#include "made_fixes.h"
#include "math/parallel.h"
#include "piste/model/imu_errors.h"
#include "piste/model/rate_regression.h"
#include "piste/model/unit_scales.h"
#include "piste/solve/recent_motion.h"
#include "piste/solve/rest_updates.h"
#include "piste/solve/sample_noise.h"
#include "piste/solve/standing_force.h"

namespace piste {
namespace {

// s between nodes at least. What the IMU tells over less is 1e16 times what a fix tells, and normal equations in double
// precision cannot hold both. A body at 5 m/s² changes its velocity by a centimetre a second.
constexpr double kMoment = 2e-3;
// s by which delays may grow over a run as a clock drifts: 100 ppm of three hours.
constexpr double kRoomToDrift = 1;

// Takes a log as a filter does, and lays it out as a chain.
class ChainLayer {
 public:
  ChainLayer(const Log& log, const FilterOptions& options, const BatchLayout& layout, double start,
             const std::shared_ptr<const Reference>& reference, const FixWeights& weights, double longest, Chain& chain)
      : world_(log.world),
        options_(options),
        units_(UnitScales::across(options)),
        reference_(reference),
        weights_(weights),
        longest_(longest),
        sources_(options),
        layout_(layout),
        clock_from_(options.clock_from.value_or(start)),
        time_(start),
        x_(reference->start),
        gravity_(log.world.gravity(x_.p_wb)),
        chain_(chain) {
    delays_.assign(sources_.all().size(), 0);
    find_delays();
    look_ahead_ = std::max(0.0, *std::max_element(delays_.begin(), delays_.end()) + kSameInstant);
    if (layout.whole.has(Block::kClockDrift)) look_ahead_ += kRoomToDrift;
    const std::size_t samples = log.imu.size(), fixes = weights.size();
    const double duration = samples > 0 ? std::max(0.0, log.imu.back().time - start) : 0;
    const auto nodes = fixes + static_cast<std::size_t>(2 * duration / longest) + 2;
    std::swap(chain_.nodes, chain_.before);
    chain_.nodes.clear();
    chain_.steps.clear();
    chain_.fixes.clear();
    chain_.epochs.clear();
    chain_.nodes.reserve(nodes);
    chain_.intervals.reserve(nodes);
    chain_.steps.reserve(samples + fixes);
    chain_.fixes.reserve(fixes);
    chain_.epochs.reserve(samples);
    chain_.nodes.push_back({start, x_, gravity_, {}});
  }

  double look_ahead() const { return look_ahead_; }

  void add(int sensor, AnyFix fix) {
    MeasurementList::visit(
        [&]<class Type>(const typename Type::Fix& known) {
          if (!Type::in_use(options_)) return;
          const int first = sources_.first<Type>(sensor);
          for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
            if (weights_.contains({first + channel, known.time})) {
              queue_.add({known.time, first + channel, sensor, channel, fix});
            }
          }
        },
        fix);
  }

  bool add(const ImuSample& sample) {
    const bool epoch = now_.has_value();
    if (epoch) process(&sample);
    before_ = now_;
    now_ = sample;
    return epoch;
  }

  void finish() {
    if (now_) process(nullptr);
    node_here();
    chain_.intervals.resize(chain_.nodes.size() - 1);
  }

 private:
  double elapsed() const { return time_ - clock_from_; }

  void find_delays() { sources_.find_delays(options_, layout_.whole, x_, elapsed(), delays_); }

  void process(const ImuSample* after) {
    const ImuSample& sample = *now_;
    if (layout_.whole.has(Block::kClockDrift)) find_delays();
    noise_ = sample_noise_.of(sample, options_.sensor);
    rate_variance_ = noise_.gyro / sample.interval;
    rate_beside_ = rate_beside(before_ ? &*before_ : nullptr, sample, after);
    still_ = sample.at_rest && !sample.gap;
    // What scales of several units do across the axes is as it was found in the round before.
    ImuStep step = without_rest(units_.get(), make_step(before_ ? &*before_ : nullptr, sample, after), x_);
    const double begin = sample.time - sample.interval;
    if (time_ > begin + kSameInstant) {  // the start is within this sample
      if (time_ >= sample.time - kSameInstant) {
        note_epoch(sample.time);
        return;
      }
      step = split(step, time_ - begin).second;
    }
    const Estimate target = next_of_reference();
    told_ = motion_between(x_, target, step.dt, world_.earth_rate(), gravity_);
    if (sample.at_rest && !rest_.withdrawn()) {  // as in a filter
      standing_.stand(target, gravity_.value, step.dt);
      told_ = {.rate = Vector3d::Zero(), .force = standing_.value()};
    } else {
      standing_.move();
    }
    bool at_end = false;
    const auto arrive = [&] {
      if (at_end) return;
      world_.follow(gravity_, x_.p_wb);
      x_ = target;
      time_ = sample.time;
      add_step(step);
      at_end = true;
    };
    while (const std::optional<QueuedFix> fix = queue_.take(sample.time, delays_)) {
      const double delay = delays_[static_cast<std::size_t>(fix->source)];
      const double into_step = fix->time - delay - time_;
      if (into_step < -kSameInstant) continue;  // it belongs before the start
      if (at_end || into_step >= step.dt - kSameInstant) {
        arrive();
        measure(*fix, step, step.dt, delay);
      } else if (into_step <= kSameInstant) {
        measure(*fix, step, 0, delay);
      } else {
        const auto [first, second] = split(step, into_step);
        advance(first);
        step = second;
        measure(*fix, step, 0, delay);
      }
    }
    arrive();
    if (const std::optional<RestFix> fix = rest_.add(sample, options_.behaviour.rest)) {
      measure_if_known<ZeroUpdates>(*fix, step);
    }
    make_fixes(sample, options_, [&]<class Type>(const typename Type::Fix& fix) { measure_if_known<Type>(fix, step); });
    if (time_ - chain_.nodes.back().time > longest_ - 0.5 * sample.interval) node_here();
    if (!still_) rate_regression_.add(sample, rate_beside_, x_);
    note_epoch(sample.time);
  }

  // That of the epoch that is processed.
  const Estimate& next_of_reference() { return reference_.at(now_->time).x; }

  void advance(const ImuStep& step) {
    world_.follow(gravity_, x_.p_wb);
    mechanize(x_, correct(step, x_), world_.earth_rate(), gravity_);
    time_ += step.dt;
    add_step(step);
  }

  void add_step(const ImuStep& step) {
    motion_.add(step, x_.q_wb);
    chain_.steps.push_back({step, noise_, told_});
  }

  void node_here() {
    if (pending_ == chain_.steps.size()) return;  // there is one
    if (chain_.nodes.size() > chain_.intervals.size()) chain_.intervals.emplace_back();
    ChainInterval& interval = chain_.intervals[chain_.nodes.size() - 1];
    interval.first = pending_;
    interval.last = chain_.steps.size();
    ChainNode& node = chain_.nodes.emplace_back();
    node.time = time_;
    node.x = x_;
    node.gravity = gravity_;
    pending_ = chain_.steps.size();
  }

  // A fix that no log has, at the end of the step.
  template <class Type>
  void measure_if_known(const typename Type::Fix& fix, const ImuStep& step) {
    const int first = sources_.first<Type>(0);
    for (int channel = 0; channel < static_cast<int>(Type::kChannels.size()); ++channel) {
      if (!weights_.contains({first + channel, fix.time})) continue;
      measure({fix.time, first + channel, 0, channel, fix}, step, step.dt, 0);
    }
  }

  void measure(const QueuedFix& fix, const ImuStep& step, double into_step, double delay) {
    // What belongs a moment after a node is compared with it, as a fix that comes late is (MeasurementContext::moved).
    double after = time_ - chain_.nodes.back().time;
    if (after > kMoment) {
      node_here();
      after = 0;
    }
    ChainFix out{.place = fix,
                 .node = chain_.nodes.size() - 1,
                 .step = step,
                 .into_step = into_step,
                 .elapsed = elapsed(),
                 .moved = delay + after,
                 .rate_variance = rate_variance_,
                 .rate_beside = rate_beside_,
                 .rate_regression = rate_regression_,
                 .still = still_,
                 .recent = motion_.at(x_.q_wb, options_.sensor)};
    chain_.fixes.push_back(std::move(out));
  }

  void note_epoch(double time) {
    const std::size_t interval = chain_.nodes.size() - 1, steps = chain_.steps.size() - pending_;
    chain_.epochs.push_back({time, interval, steps});
  }

  const World& world_;
  const FilterOptions& options_;
  std::shared_ptr<const UnitScales> units_;
  Reference::Reader reference_;
  const FixWeights& weights_;
  double longest_;
  MeasurementSources sources_;
  const BatchLayout& layout_;
  double clock_from_;
  double time_, look_ahead_ = 0;
  Estimate x_;
  Gravity gravity_;
  std::size_t pending_ = 0;  // first step since the last node
  std::vector<double> delays_;
  std::optional<ImuSample> before_, now_;
  StepNoise noise_;
  Vector3d rate_variance_ = Vector3d::Zero(), rate_beside_ = Vector3d::Zero();
  RateRegression rate_regression_;
  bool still_ = false;
  BodyMotion told_;
  FixQueue queue_;
  SampleNoise sample_noise_;
  RestUpdates rest_;
  StandingForce standing_;
  MotionMean motion_;
  Chain& chain_;
};

ImuErrors errors_of(const Estimate& x) {
  return {x.gyro_bias + x.gyro_drift, x.accel_bias + x.accel_drift, x.gyro_scale, x.accel_scale};
}

// Whether the noise of an interval and its derivatives are the same with the errors of the IMU of two estimates, but
// for a thousandth of themselves: so much a rotation, a scale or a force that differs by this part changes them. A
// solution moves by that part of what it moves at all.
bool hardly_differ(const ImuErrors& a, const ImuErrors& b, double time) {
  constexpr double kPart = 1e-3;
  return (a.rate - b.rate).norm() * time < kPart && (a.force - b.force).norm() < kPart * kStandardGravity &&
         (a.gyro_scale - b.gyro_scale).norm() < kPart && (a.accel_scale - b.accel_scale).norm() < kPart;
}

// The samples of an interval, which may have noise and derivatives already.
void sum_up(Chain& chain, std::size_t i, bool known, ProcessSteps& processes) {
  ChainInterval& interval = chain.intervals[i];
  Preintegration sum(chain.nodes[i].x);
  if (known) interval.sum.by_imu.rightCols<6>().setZero();
  for (std::size_t k = interval.first; k < interval.last; ++k) {
    const ChainStep& s = chain.steps[k];
    processes.over(s.step.dt);
    const DriftStep &gyro = processes.of(Block::kGyroDrift), &accel = processes.of(Block::kAccelDrift);
    if (known) {
      add_to_scales(interval.sum.by_imu, sum.move(s.step, gyro, accel), s.told);
    } else {
      sum.add(s.step, s.noise, s.told, gyro, accel);
    }
  }
  if (known) {
    static_cast<SummedMotion&>(interval.sum) = sum.motion();
  } else {
    interval.sum = sum.sum();
    interval.summed = errors_of(chain.nodes[i].x);
    interval.count = interval.last - interval.first;
  }
}

}  // namespace

DriftStep process_step(const FilterOptions& options, Block block, double dt) {
  const std::optional<BlockProcess> process = info(block).process(options);
  if (!process) return {};
  const DiscreteProcess d = discretise(process->law, dt);
  return {d.transition, d.variance * process->weight};
}

void ProcessSteps::over(double dt) {
  if (dt == dt_) return;
  dt_ = dt;
  for (const Block b : layout_.node.blocks) {
    if (!is_navigation(b)) steps_[static_cast<std::size_t>(b)] = process_step(options_, b, dt);
  }
}

void lay_chain(const Log& log, const FilterOptions& options, const BatchLayout& layout, double start,
               const std::shared_ptr<const Reference>& reference, const FixWeights& weights, double longest,
               std::size_t threads, Chain& chain) {
  ChainLayer layer(log, options, layout, start, reference, weights, longest, chain);
  const double end = (reference->size() == 0 ? start : reference->last_time()) + kSameInstant;
  LogPlace place = place_at(log, start, {.end = end});
  Feeder feeder(log, place, layer);
  while (!feeder.done()) feeder.step();
  layer.finish();
  const auto same_time = [](const ChainNode& a, const ChainNode& b) {
    return std::abs(a.time - b.time) <= kSameInstant;
  };
  std::size_t k = 0;
  for (ChainNode& node : chain.nodes) {
    node.side = node.x;
    while (k < chain.before.size() && chain.before[k].time < node.time - kSameInstant) ++k;
    if (k == chain.before.size() || !same_time(chain.before[k], node)) continue;
    node.x = chain.before[k].x;
    node.side = chain.before[k].side;
  }
  // Whether the interval is the one that was summed before. A delay that has changed may have moved nodes.
  const auto known = [&](std::size_t i) {
    const ChainInterval& interval = chain.intervals[i];
    return i + 1 < chain.before.size() && same_time(chain.before[i], chain.nodes[i]) &&
           same_time(chain.before[i + 1], chain.nodes[i + 1]) && interval.count == interval.last - interval.first &&
           hardly_differ(errors_of(chain.nodes[i].x), interval.summed, interval.sum.time);
  };
  for_each_stretch(chain.intervals.size(), kPerTask, threads, [&](std::size_t first, std::size_t last) {
    ProcessSteps processes(options, layout);
    for (std::size_t i = first; i < last; ++i) sum_up(chain, i, known(i), processes);
  });
}

}  // namespace piste
