#include "chain.h"

#include <cmath>
#include <optional>

#include "core/time_search.h"
#include "filter/feeder.h"
#include "filter/recent_motion.h"
#include "filter/standing_force.h"
#include "math/parallel.h"
#include "model/imu_errors.h"
#include "model/imu_scales.h"
#include "walker/walker.h"

namespace piste {
namespace {

// The least interval between nodes [s]. Over less, the information of the IMU is 1e16 times that of a fix, and normal
// equations in double precision cannot hold both. A body at 5 m/s² changes its velocity by a centimetre a second.
constexpr double kMoment = 2e-3;

// Takes the walk that the filter took, and lays it out as a chain.
class ChainLayer {
 public:
  ChainLayer(const Log& log, const FilterOptions& options, const BatchLayout& layout, double start,
             const std::shared_ptr<const Reference>& reference, const FixWeights& weights, double longest, Chain& chain)
      : world_(log.world),
        imu_scales_(ImuScales::across(options)),
        reference_(reference),
        weights_(weights),
        longest_(longest),
        time_(start),
        x_(reference->start),
        gravity_(log.world.gravity(x_.p_wb)),
        walker_(options, layout.whole, start, x_),
        chain_(chain) {
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

  double look_ahead() const { return walker_.look_ahead(); }
  void add(int sensor, const AnyFix& fix) { walker_.add(sensor, fix, *this); }
  bool add(const ImuSample& sample) { return walker_.add(sample, *this); }
  void finish() {
    walker_.finish(*this);
    node_here();
    chain_.intervals.resize(chain_.nodes.size() - 1);
  }

  // The interface of the walk (walker.h).
  double time() const { return time_; }
  const Estimate& estimate() const { return x_; }
  // The cross-axis effect of the scales of several IMUs, as estimated in the round before.
  const ImuScales* imu_scales() const { return imu_scales_.get(); }
  bool resting() const { return walker_.sample().at_rest && !walker_.sample().gap; }
  bool takes(int source, double time) const { return weights_.contains({source, time}); }

  static StepNoise begin_sample(const StepNoise& stated) { return stated; }

  void begin_step(const ImuStep& step) {
    target_ = reference_.at(walker_.sample().time).x;
    reference_motion_ = motion_between(x_, target_, step.dt, world_.earth_rate(), gravity_);
    if (const Vector3d* force = standing_.add(walker_.at_rest(), target_, gravity_.value, step.dt)) {
      reference_motion_ = {.rate = Vector3d::Zero(), .force = *force};
    }
  }

  void advance(const ImuStep& step) {
    world_.follow(gravity_, x_.p_wb);
    mechanize(x_, correct(step, x_), world_.earth_rate(), gravity_);
    time_ += step.dt;
    add_step(step);
  }

  void arrive(const ImuStep& step) {
    world_.follow(gravity_, x_.p_wb);
    x_ = target_;
    time_ = walker_.sample().time;
    add_step(step);
  }

  void measure(const QueuedFix& fix, const Moment& at) {
    if (at.lag > 0) return;  // it belongs before the start
    // What belongs a moment after a node is compared with it, as a fix that comes late is (MeasurementContext::moved).
    double after = time_ - chain_.nodes.back().time;
    if (after > kMoment) {
      node_here();
      after = 0;
    }
    chain_.fixes.push_back({.place = fix,
                            .node = chain_.nodes.size() - 1,
                            .step = at.step,
                            .into_step = at.into_step,
                            .elapsed = walker_.elapsed(time_),
                            .moved = at.delay + after,
                            .rate_variance = walker_.rate_variance(),
                            .neighbour_rate = walker_.neighbour_rate(),
                            .rate_regression = walker_.rate_regression(),
                            .still = resting(),
                            .recent = motion_.at(x_.q_wb, walker_.options().sensor)});
  }

  template <class Type>
  bool measure(const typename Type::Fix&, const QueuedFix& place, const Moment& at) {
    measure(place, at);
    return true;
  }

  void end_sample() {
    const ImuSample& sample = walker_.sample();
    if (time_ - chain_.nodes.back().time > longest_ - 0.5 * sample.interval) node_here();
    chain_.epochs.push_back({sample.time, chain_.nodes.size() - 1, chain_.steps.size() - pending_});
  }

 private:
  void add_step(const ImuStep& step) {
    motion_.add(step, x_.q_wb);
    chain_.steps.push_back({step, walker_.noise(), reference_motion_});
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

  const World& world_;
  std::shared_ptr<const ImuScales> imu_scales_;
  Reference::Reader reference_;
  const FixWeights& weights_;
  double longest_;
  double time_;
  Estimate x_, target_;  // at the time, and at the end of the sample
  Gravity gravity_;
  Walker walker_;
  std::size_t pending_ = 0;  // first step since the last node
  BodyMotion reference_motion_;
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
  if (known) interval.sum.by_imu.rightCols<kImuErrorSize - kConstantErrors>().setZero();
  for (std::size_t k = interval.first; k < interval.last; ++k) {
    const ChainStep& s = chain.steps[k];
    processes.over(s.step.dt);
    const DriftStep &gyro = processes.of(Block::kGyroDrift), &accel = processes.of(Block::kAccelDrift);
    if (known) {
      add_to_scales(interval.sum.by_imu, sum.move(s.step, gyro, accel), s.reference);
    } else {
      sum.add(s.step, s.noise, s.reference, gyro, accel);
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
  for (Feeder feeder(log, place_at(log, start, {.end = end}), layer); !feeder.done();) feeder.step();
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
