// Receivers that lie, and IMUs that fault: how far position is from what is claimed of it, at every epoch, filtered and
// smoothed. What must hold: 5 sigma, and that a lie costs no more than an outage of the same length, neither in error
// nor in what is claimed.
//
// Not held to it: a ramp of a receiver without velocities, or with coarse ones, or one that does not return. Filter and
// receiver then part so slowly that neither can be told to be wrong.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <vector>

#include "condition/ramp_faults.h"
#include "piste/consistency/disputes.h"
#include "piste/math/units.h"
#include "piste/sim/random.h"
#include "piste/smoother/rts.h"
#include "piste/start/attitude_noise.h"
#include "piste/start/initial_stretch.h"
#include "support/simulated_case.h"

namespace piste::test {
namespace {

constexpr double kHonest = 5;                // sigma
constexpr double kBegin = 40, kLength = 30;  // s of the lie, since the departure
const Vector3d kAside = Vector3d(0.6, -0.7, 0.39).normalized();

struct Errors {
  double largest = 0, over_sigma = 0;  ///< of any axis of position; over what is claimed
  double claimed = 0;                  ///< largest sigma of any axis of position
  double last = 0;
  double attitude = 0;  ///< largest angle [deg]
  double inside = 0;    ///< share of the rows whose position is within 3 sigma in each axis
};

// Errors of a solution, of whose rows `truths` are true.
Errors errors_of(const Solution& s, const std::vector<TruthState>& truths, const World& world, const Interval& during) {
  Errors e;
  double rows = 0, inside = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    if (!during.contains(s.time(i))) continue;
    const TruthState& is = truths[i];
    const Estimate x = s.estimate(i);
    const Vector3d error = x.p_wb - s.world().from_geodetic(world.to_geodetic(is.p_wb));
    e.largest = std::max(e.largest, error.cwiseAbs().maxCoeff());
    e.claimed = std::max(e.claimed, s.sigmas(i).position.maxCoeff());
    const double over_sigma = error.cwiseAbs().cwiseQuotient(s.sigmas(i).position).maxCoeff();
    e.over_sigma = std::max(e.over_sigma, over_sigma);
    ++rows;
    inside += over_sigma <= 3 ? 1 : 0;
    e.last = error.norm();
    e.attitude = std::max(e.attitude, so3_log(x.q_wb * is.q_wb.conjugate()).norm() / kDegree);
  }
  e.inside = inside / rows;
  return e;
}

struct Result {
  Errors filtered, smoothed;
  Solution solution;
};

Result solve(const Case& c, const Log& log, const FoundStart& found, const std::string& what,
             Interval during = {0, 1e300}) {
  const FilterRun run = filter_from(initial_stretch(log, c.options, found), log, c.options, found, Keep::kHistory);
  const Truth& truth = c.simulation.bodies[0];
  std::vector<TruthState> truths;  // filtered and smoothed have the same rows
  for (std::size_t i = 0; i < run.solution.size(); ++i) truths.push_back(truth.at(run.solution.time(i)));
  const Solution smoothed = smooth_rts(run);
  EXPECT_EQ(smoothed.size(), truths.size());
  Result r{errors_of(run.solution, truths, truth.world(), during), errors_of(smoothed, truths, truth.world(), during),
           run.solution};
  fmt::print(
      "{:32s} filtered {:7.2f} m {:5.1f} sigma of {:6.3f} m, smoothed {:6.2f} m {:5.1f} sigma of {:6.3f} m, at the end "
      "{:.2f} m\n",
      what, r.filtered.largest, r.filtered.over_sigma, r.filtered.claimed, r.smoothed.largest, r.smoothed.over_sigma,
      r.smoothed.claimed, r.filtered.last);
  return r;
}

void expect_honest(const Result& r, const std::string& what) {
  EXPECT_LE(r.filtered.over_sigma, kHonest) << what;
  EXPECT_LE(r.smoothed.over_sigma, kHonest) << what;
}

// Some room: which of the errors of a coasting filter is the largest is chance.
void expect_no_worse(const Result& r, const Result& outage, const std::string& what) {
  EXPECT_LE(r.filtered.largest, 1.3 * outage.filtered.largest) << what;
  EXPECT_LE(r.smoothed.largest, 1.3 * outage.smoothed.largest) << what;
}

void expect_no_less_sure(const Result& r, const Result& than, const std::string& what, double room = 1.3) {
  EXPECT_LE(r.filtered.claimed, room * than.filtered.claimed) << what;
  EXPECT_LE(r.smoothed.claimed, room * than.smoothed.claimed) << what;
}

std::size_t count(const Solution& s, Outcome outcome) {
  return static_cast<std::size_t>(std::count_if(s.innovations.begin(), s.innovations.end(),
                                                [&](const Innovation& v) { return v.outcome == outcome; }));
}

Case receiver_case(const std::string& motion, const std::string& receiver, bool velocity, std::uint64_t seed = 1) {
  Case c = make_case(motion, 40, seed, [&](Scenario& s) {
    const Scenario all = read_scenario(s.file);
    s.gnss = {all.gnss[receiver == "gnss_l1" ? 1 : 0]};
    s.motion.run = 100;
    if (!velocity) s.gnss[0].velocity_noise.setZero();
  });
  c.options.gnss[0].use_velocity = velocity;
  c.options.gnss[0].drift = c.scenario.gnss[0].position_drift;
  if (c.options.gnss[0].drift) c.options.estimate.push_back(Block::kGnssPositionDrift);
  return c;
}

struct Kind {
  const char *motion, *receiver;
  bool velocity;
};

class LyingReceiver : public ::testing::TestWithParam<Kind> {
 protected:
  bool lies(const GnssFix& fix, double length = kLength) const {
    return fix.time >= begin_ && fix.time <= begin_ + length;
  }
  /// Position off by a step and a ramp; where `also_velocity`, the velocity is that of the lie.
  Log lie(double step, double ramp, bool also_velocity, double length = kLength) const {
    Log log = log_;
    for (GnssFix& fix : log.gnss[0]) {
      if (!lies(fix, length)) continue;
      fix.position += (step + ramp * (fix.time - begin_)) * kAside;
      if (also_velocity && fix.velocity) fix.velocity->value += ramp * kAside;
    }
    return log;
  }
  Result outage() const {
    Log log = log_;
    std::erase_if(log.gnss[0], [&](const GnssFix& fix) { return lies(fix); });
    return run(log, "outage");
  }
  Result run(const Log& log, const std::string& what) const { return solve(case_, log, start_, what); }
  bool coarse() const { return case_.options.gnss[0].drift.has_value(); }

  const Case case_ = receiver_case(GetParam().motion, GetParam().receiver, GetParam().velocity);
  const Log log_ = case_.log();
  const FoundStart start_ = find_start(log_, case_.options, {});
  const double begin_ = case_.under_way() + kBegin;
};

TEST_P(LyingReceiver, IsNotSeenWhereThereIsNone) {
  const Result r = run(log_, "clean");
  expect_honest(r, "clean");
  EXPECT_LT(r.filtered.claimed, coarse() ? 0.9 : 0.015);
  EXPECT_LT(r.smoothed.claimed, coarse() ? 0.7 : 0.012);
  EXPECT_LT(count(r.solution, Outcome::kRejected), 10U);
  EXPECT_EQ(count(r.solution, Outcome::kDisputed) + count(r.solution, Outcome::kRepeated), 0U);
  EXPECT_EQ(count(r.solution, Outcome::kReadmitted), 0U);
  EXPECT_TRUE(disputes_of(r.solution, 1).empty());
}

TEST_P(LyingReceiver, OneFixInTenIsAnOutlier) {
  const Result clean = run(log_, "clean");
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Log log = log_;
    RandomStream random(seed, "outliers");
    std::size_t outliers = 0;
    for (std::size_t i = 1; i < log.gnss[0].size(); ++i) {
      if (random.uniform() > 0.1) continue;
      ++outliers;
      log.gnss[0][i].position += (2 + 98 * random.uniform()) * random.normal3().normalized();
    }
    const std::string what = fmt::format("outliers {}", seed);
    const Result r = run(log, what);
    expect_honest(r, what);
    EXPECT_LT(r.smoothed.largest, 1.3 * clean.smoothed.largest) << what;
    expect_no_less_sure(r, clean, what);
    if (coarse()) continue;  // 2 m may be within its gate
    EXPECT_GE(count(r.solution, Outcome::kRejected), outliers) << what;
  }
}

TEST_P(LyingReceiver, JumpsAsideAndBack) {
  const Result without = outage();
  for (const double step : {2., 20., 50.}) {
    const std::string what = fmt::format("step of {} m", step);
    const Result r = run(lie(step, 0, false), what);
    expect_honest(r, what);
    expect_no_worse(r, without, what);
    expect_no_less_sure(r, without, what);
    const auto disputes = disputes_of(r.solution);
    ASSERT_EQ(disputes.size(), 1U) << what;
    EXPECT_EQ(r.solution.sources[static_cast<std::size_t>(disputes[0].source)], "gnss[0].position");
    EXPECT_NEAR(disputes[0].during.start, begin_, 0.3) << what;
    EXPECT_NEAR(disputes[0].during.end, begin_ + kLength, 0.3) << what;
    EXPECT_NEAR(disputes[0].size, step, coarse() ? 1.5 : 0.2) << what;
    EXPECT_FALSE(disputes[0].believed) << what;
  }
}

TEST_P(LyingReceiver, JumpsAndDriftsAway) {
  const Result r = run(lie(20, 2, true), "step of 20 m, ramp of 2 m/s");
  expect_honest(r, "step and ramp");
  expect_no_less_sure(r, outage(), "step and ramp", 2.2);  // the way back counts as well
}

// The ramp is seen by what the velocities say, in its positions alone or in both.
class LyingReceiverWithVelocities : public LyingReceiver {};

TEST_P(LyingReceiverWithVelocities, DriftsAway) {
  const Result without = outage();
  const Result alone = run(lie(0, 0.5, false), "ramp of position alone");
  expect_honest(alone, "ramp of position alone");
  expect_no_less_sure(alone, without, "ramp of position alone");
  if (coarse()) return;
  const Result both = run(lie(0, 0.5, true), "ramp");
  expect_honest(both, "ramp");
  expect_no_less_sure(both, without, "ramp");
}

TEST_P(LyingReceiver, RepeatsItsLastFixInATurn) {
  Log log = log_;
  const GnssFix* held = nullptr;
  std::size_t repeated = 0;
  for (GnssFix& fix : log.gnss[0]) {
    if (!lies(fix, 10)) continue;
    if (held != nullptr) {
      fix.position = held->position;
      fix.velocity = held->velocity;
      ++repeated;
    } else {
      held = &fix;
    }
  }
  const Result r = run(log, "repeated fix");
  expect_honest(r, "repeated fix");
  expect_no_less_sure(r, outage(), "repeated fix");
  EXPECT_EQ(count(r.solution, Outcome::kRepeated), repeated);
}

// Nobody can know for ever: after FaultDetectionOptions::distrust the receiver is believed, and what was known until
// then stays.
TEST_P(LyingReceiver, IsBelievedInTheEnd) {
  const double distrust = case_.options.behaviour.trust.distrust;
  const Log log = lie(20, 0, false, 1e3);
  const Result r = run(log, "step for good");
  EXPECT_NEAR(r.filtered.last, 20, 2);
  EXPECT_EQ(disputes_of(r.solution).size(), 1U);
  const Result before = solve(case_, log, start_, "until it is believed", {0, begin_ + distrust - 0.5});
  EXPECT_LE(before.filtered.over_sigma, kHonest);
}

std::string name_of(const ::testing::TestParamInfo<Kind>& each) {
  return fmt::format("{}_{}{}", each.param.motion, each.param.receiver, each.param.velocity ? "" : "_positions");
}

INSTANTIATE_TEST_SUITE_P(All, LyingReceiver,
                         ::testing::Values(Kind{"ski", "gnss_l1l2", true}, Kind{"ski", "gnss_l1l2", false},
                                           Kind{"bicycle", "gnss_l1l2", true}, Kind{"bicycle", "gnss_l1l2", false},
                                           Kind{"giant_slalom", "gnss_l1l2", true}, Kind{"ski", "gnss_l1", true}),
                         name_of);
INSTANTIATE_TEST_SUITE_P(All, LyingReceiverWithVelocities,
                         ::testing::Values(Kind{"ski", "gnss_l1l2", true}, Kind{"bicycle", "gnss_l1l2", true},
                                           Kind{"giant_slalom", "gnss_l1l2", true}, Kind{"ski", "gnss_l1", true}),
                         name_of);

// Positions run away from honest velocities, each step within the gate: the filter would follow them.
TEST(SlowRamp, IsLetGoFromItsBeginning) {
  for (const double ramp : {0.1, 0.3}) {
    double filtered = 0, smoothed = 0;
    const int runs = seeds(3, 20);
    for (int seed = 1; seed <= runs; ++seed) {
      const Case c = receiver_case("ski", "gnss_l1l2", true, static_cast<std::uint64_t>(seed));
      Log log = c.log();
      const double begin = c.under_way() + kBegin;
      for (GnssFix& fix : log.gnss[0]) {
        const double since = fix.time - begin;
        if (since >= 0 && since < kLength) fix.position += ramp * since * kAside;
      }
      const auto found = exclude_ramp_faults(log.gnss[0], c.options.behaviour.trust, log.world);
      const std::string what = fmt::format("ramp of {} m/s, seed {}", ramp, seed);
      ASSERT_EQ(found.size(), 1u) << what;
      const Result r = solve(c, log, find_start(log, c.options, {}), what);
      expect_honest(r, what);
      EXPECT_EQ(count(r.solution, Outcome::kReadmitted), 0U) << what;
      filtered += r.filtered.inside / runs;
      smoothed += r.smoothed.inside / runs;
    }
    fmt::print("ramp of {} m/s: {:.3f} filtered and {:.3f} smoothed inside 3 sigma\n", ramp, filtered, smoothed);
    EXPECT_GT(filtered, 0.98) << ramp;
    EXPECT_GT(smoothed, 0.98) << ramp;
  }
}

// Where the velocities are not to be used, they accuse no position.
TEST(SlowRamp, IsNoMatterOfVelocitiesThatAreNotUsed) {
  Case c = receiver_case("ski", "gnss_l1l2", true);
  c.options.gnss[0].use_velocity = false;
  Log log = c.log();
  for (GnssFix& fix : log.gnss[0]) fix.runs_away = true;
  const Result r = solve(c, log, find_start(log, c.options, {}), "velocities are not used");
  EXPECT_EQ(count(r.solution, Outcome::kDisputed), 0U);
  EXPECT_LT(r.filtered.claimed, 0.015);
}

TEST(SlowRamp, IsNotSeenInCleanRuns) {
  for (const char* receiver : {"gnss_l1l2", "gnss_l1"}) {
    for (int seed = 1; seed <= seeds(5, 200); ++seed) {
      const Case c = receiver_case("ski", receiver, true, static_cast<std::uint64_t>(seed));
      EXPECT_TRUE(c.log().counts.gnss_ramps.at(0).empty()) << receiver << " " << seed;
    }
  }
}

// The turns clip, and a lie is still seen.
TEST(FaultyImu, ClipsInTheTurns) {
  const Case c = receiver_case("giant_slalom", "gnss_l1l2", true);
  const Log log = c.log();
  EXPECT_GT(log.counts.imu_clipped, 10U);
  const Result r = solve(c, log, find_start(log, c.options, {}), "clipped turns");
  expect_honest(r, "clipped turns");
  EXPECT_LT(r.filtered.claimed, 0.015);
}

// Twenty samples are lost and their time with them: from then on attitude and velocity are of 0.2 s before. No more is
// asked than to follow the receiver: neither is the lag known, nor what it makes of the sensor's errors.
TEST(FaultyImu, LosesSamplesUnseen) {
  for (const bool velocity : {true, false}) {
    const Case c = receiver_case("ski", "gnss_l1l2", velocity);
    Log log = c.log();
    const FoundStart start = find_start(log, c.options, {});
    const double lost = c.under_way() + kBegin;
    std::erase_if(log.imu, [&](const ImuSample& s) { return s.time > lost && s.time < lost + 0.2; });
    for (ImuSample& s : log.imu) {
      if (s.time > lost) s.time -= 0.2;
    }
    const Result r = solve(c, log, start, "20 samples lost");
    EXPECT_LT(r.filtered.largest, 0.4);
    EXPECT_LT(r.smoothed.largest, 0.2);
    EXPECT_LT(r.filtered.last, 0.1);
  }
}

// A rate that no gyroscope can measure, in one sample.
TEST(FaultyImu, Spikes) {
  Case c = make_case("ski", 40, 1, [](Scenario& s) { s.attitude = read_scenario(s.file).attitude; });
  c.options.attitude[0].drift = c.scenario.attitude[0].drift;
  c.options.estimate.push_back(Block::kBoresight);
  Recording recording = c.simulation.recording(0);
  const auto row = static_cast<std::size_t>(45 * 100);  // 25 s under way
  recording.imu.gyro[row].x() = 1e6;
  const Log log = condition(recording, c.conditioning);
  c.options = with_white_part(std::move(c.options), log);
  EXPECT_GE(log.counts.imu_clipped, 1U);
  const Interval run{c.under_way(), c.under_way() + 60};
  const Result r = solve(c, log, find_start(log, c.options, {}), "spike of 1e6 rad/s", run);
  EXPECT_LT(r.smoothed.largest, 0.1);
  EXPECT_LT(r.smoothed.attitude, 0.3);
  expect_honest(r, "spike");
  EXPECT_LT(r.filtered.claimed, 0.015);
}

TEST(LockedOut, ByAStartThatIsWrong) {
  const Case c = receiver_case("ski", "gnss_l1l2", true);
  const Log log = c.log();
  Start start = find_start(log, c.options, {}).start;
  start.x.p_wb += 100 * kAside;
  start.covariance.topLeftCorner<3, 3>().setIdentity();
  const Result r = solve(c, log, {start, ""}, "start 100 m aside", {start.time + 1, 1e300});
  EXPECT_LT(r.filtered.largest, 0.05);
  EXPECT_LT(r.filtered.claimed, 0.02);  // at rest, where fixes are as coarse as a sway
  expect_honest(r, "start 100 m aside");
}

// A false ambiguity in the first seconds, before anything could contradict it.
TEST(LockedOut, ByFirstFixesThatAreWrong) {
  const Case c = receiver_case("ski", "gnss_l1l2", true);
  for (const double lasts : {0.3, 2.0, 8.0}) {
    Recording recording = c.simulation.recording(0);
    for (GeodeticFix& fix : recording.gnss[0].fixes) {
      if (fix.time >= recording.gnss[0].fixes.front().time + lasts) break;
      fix.position.latitude += 3e-6;  // 19 m
    }
    const Log log = condition(recording, c.conditioning);
    ASSERT_GT(log.counts.gnss_contradicted.at(0).count, 0u);
    const std::string what = fmt::format("first {:.1f} s 19 m aside", lasts);
    const Result r = solve(c, log, find_start(log, c.options, {}), what);
    EXPECT_LT(r.filtered.largest, 0.1) << what;
    expect_honest(r, what);
  }
}

}  // namespace
}  // namespace piste::test
