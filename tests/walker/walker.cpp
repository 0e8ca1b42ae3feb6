// The walk over a log: which steps and measurements come out, and in what order.

#include "walker/walker.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "piste/core/error.h"

namespace piste {
namespace {

using Events = std::vector<std::string>;

// Keeps the calls of a walk.
struct Listener {
  double now = 0;
  Estimate x = {};
  bool refuses = false, ignores_velocities = false;
  Walker walker = {};
  Events told = {};

  double time() const { return now; }
  const Estimate& estimate() const { return x; }
  static const ImuScales* imu_scales() { return nullptr; }
  bool resting() const { return walker.at_rest(); }
  bool takes(int source, double) const { return !(ignores_velocities && source == 1); }
  static StepNoise begin_sample(const StepNoise& stated) { return stated; }
  void begin_step(const ImuStep&) {}
  void advance(const ImuStep& step) {
    now += step.dt;
    told.push_back(fmt::format("advance to {:.4f}", now));
  }
  void arrive(const ImuStep& step) {
    now += step.dt;
    told.push_back(fmt::format("arrive at {:.4f}", now));
    now = walker.sample().time;
  }
  void measure(const QueuedFix& fix, const Moment& at) {
    const std::string late = at.lag > 0 ? fmt::format(", {:.4f} before", at.lag) : "";
    told.push_back(fmt::format("{} of {:.4f} after {:.4f}{}",
                               walker.sources().all()[static_cast<std::size_t>(fix.source)].name, fix.time,
                               at.into_step, late));
  }
  template <class Type>
  bool measure(const typename Type::Fix&, const QueuedFix& place, const Moment& at) {
    measure(place, at);
    return !refuses;
  }
  void end_sample() { told.emplace_back("end"); }
};

FilterOptions two_channels(double delay, double velocity_delay) {
  FilterOptions options;
  options.estimate.clear();
  options.gnss = {{.name = "", .delay = delay, .velocity_delay = velocity_delay}};
  return options;
}

Listener at(double start, const FilterOptions& options) {
  Listener to{.now = start};
  to.walker = Walker(options, StateLayout(options.estimate), start, to.x);
  return to;
}

void add_samples(Listener& to, double from, int count, bool rest = false) {
  for (int i = 1; i <= count; ++i) {
    to.walker.add(ImuSample{.time = from + 0.01 * i, .interval = 0.01, .at_rest = rest}, to);
  }
}

void add_fix(Listener& to, double time) {
  const Vector3d here = Vector3d::Zero(), sigma = Vector3d::Ones();
  to.walker.add(0, GnssFix{time, here, sigma, FixVelocity{here, sigma}}, to);
}

TEST(Walker, SplitsStepsWhereChannelsBelong) {
  Listener to = at(0, two_channels(0.005, 0));
  EXPECT_NEAR(to.walker.look_ahead(), 0.005, 2e-6);
  add_fix(to, 0.02);
  add_samples(to, 0, 3);
  EXPECT_EQ(to.told, (Events{"arrive at 0.0100", "end", "advance to 0.0150", "gnss[0].position of 0.0200 after 0.0000",
                             "arrive at 0.0200", "gnss[0].velocity of 0.0200 after 0.0050", "end"}));
}

TEST(Walker, WhatIsNotWantedSplitsNothing) {
  Listener to = at(0, two_channels(0, 0.005));
  to.ignores_velocities = true;
  add_fix(to, 0.02);
  add_samples(to, 0, 3);
  EXPECT_EQ(to.told,
            (Events{"arrive at 0.0100", "end", "arrive at 0.0200", "gnss[0].position of 0.0200 after 0.0100", "end"}));
}

TEST(Walker, AFixOfTheTimeBehindIsLeftOutAndADelayedOneCarriedBack) {
  Listener to = at(0, two_channels(0.008, 0));
  add_samples(to, 0, 2);
  add_fix(to, 0.009);
  EXPECT_EQ(to.walker.late(), 1U);
  add_fix(to, 0.012);
  to.told.clear();
  to.walker.finish(to);
  EXPECT_EQ(to.told, (Events{"gnss[0].position of 0.0120 after 0.0000, 0.0060 before", "advance to 0.0120",
                             "gnss[0].velocity of 0.0120 after 0.0000", "arrive at 0.0200", "end"}));
}

TEST(Walker, BeginsWithinASample) {
  Listener to = at(0.004, two_channels(0, 0));
  add_samples(to, 0, 2);
  EXPECT_EQ(to.told, (Events{"arrive at 0.0100", "end"}));
}

TEST(Walker, RestIsMeasuredAtTheEndOfASampleUntilItIsRefused) {
  FilterOptions options = two_channels(0, 0);
  options.behaviour.rest.interval = 0.01;
  options.behaviour.rest.patience = 2;
  Listener to = at(0, options);
  to.refuses = true;
  add_fix(to, 0.01);
  add_samples(to, 0, 4, true);
  const std::size_t channels = ZeroUpdates::kChannels.size();
  ASSERT_EQ(to.told.size(), 3 + 3 + 2 * channels + 2);
  EXPECT_EQ(to.told[1], "gnss[0].position of 0.0100 after 0.0100");
  EXPECT_TRUE(to.told[3].starts_with("rest")) << to.told[3];
  EXPECT_EQ(to.told.back(), "end");
  EXPECT_FALSE(to.walker.at_rest()) << "it was none";
}

TEST(Walker, ASampleThatIsNotLaterIsRefused) {
  Listener to = at(0, two_channels(0, 0));
  add_samples(to, 0, 2);
  EXPECT_THROW(to.walker.add(ImuSample{.time = 0.02, .interval = 0.01}, to), DataError);
  EXPECT_TRUE(to.walker.add(ImuSample{.time = 0.03, .interval = 0.01}, to));
}

}  // namespace
}  // namespace piste
