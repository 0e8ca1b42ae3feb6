// The verdict of made-up innovations: what holds, what does not, and the line that says so.

#include "piste/consistency/verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "piste/model/gnss.h"
#include "piste/sim/random.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

/// An innovation of which nothing is known but when it was made, and of what.
Innovation innovation_of(int source, double time, double late = 0, Outcome outcome = Outcome::kUsed) {
  return {.time = time,
          .source = source,
          .residual = Vector3d::Zero(),
          .sigma = Vector3d::Ones(),
          .outcome = outcome,
          .late = late};
}

/// Innovations of a source, ten a second, whose true sigmas are `factor` times those stated and of which successive
/// ones have this correlation.
void add_series(Solution& solution, int source, int count, double factor, double correlation = 0) {
  RandomStream random(static_cast<std::uint64_t>(source) + 1, "series");
  Vector3d z = random.normal3();
  for (int i = 0; i < count; ++i) {
    z = correlation * z + std::sqrt(1 - correlation * correlation) * random.normal3();
    const Vector3d sigma(0.1, 0.2, 0.3);
    const double nis = factor * factor * z.squaredNorm(), gate = 16.27;
    solution.innovations.push_back({.time = 10 + 0.1 * i,
                                    .source = source,
                                    .residual = factor * z.cwiseProduct(sigma),
                                    .sigma = sigma,
                                    .nis = nis,
                                    .gate = gate,
                                    .outcome = nis > gate ? Outcome::kRejected : Outcome::kUsed});
  }
}

Solution run_of(const std::vector<Block>& blocks = {}) {
  Solution s{StateLayout(blocks), World()};
  s.sources = {"gnss[0].position", "attitude[0]", "rest.velocity"};
  return s;
}

void end_with(Solution& solution, const Vector3d& gyro_scale) {
  Estimate x;
  x.gyro_scale = gyro_scale;
  Sigmas s;
  s.position = s.velocity = s.euler = Vector3d::Zero();
  s.blocks.segment<3>(full_offset(Block::kGyroScale)) = Vector3d(0.002, 0.002, 0.009);
  solution.append(0, x, s);
}

TEST(RunVerdict, TrueSigmasHold) {
  Solution s = run_of();
  end_with(s, Vector3d::Zero());
  add_series(s, 0, 600, 1);
  add_series(s, 1, 20, 5);   // too few to tell
  add_series(s, 2, 600, 5);  // no source of fixes
  const Verdict v = judge({}, {}, s, nullptr);
  EXPECT_TRUE(v.consistent);
  ASSERT_EQ(v.sources.size(), 2U);
  EXPECT_NEAR(v.sources[0].nis, 1, 0.1);
  EXPECT_NEAR(v.sources[0].whiteness, 0, 0.15);
  EXPECT_NEAR(v.sources[0].nis_error, std::sqrt(2. / 3 / 600), 0.01);
  EXPECT_LT(v.sources[0].rejected, 0.005);
  EXPECT_TRUE(std::isnan(v.sources[1].nis));
  EXPECT_EQ(verdict_line(v), "sigmas hold");
}

TEST(RunVerdict, SaysByHowMuchSigmasAreWrong) {
  for (const double factor : {0.4, 2.5}) {
    Solution s = run_of();
    end_with(s, Vector3d::Zero());
    add_series(s, 0, 600, factor);
    Verdict v = judge({}, {}, s, nullptr);
    EXPECT_FALSE(v.consistent);
    EXPECT_FALSE(v.sources[0].holds);
    EXPECT_FALSE(v.sources[0].reasons.empty());
    for (const std::string& reason : v.sources[0].reasons)
      EXPECT_NE(reason.find(" may be"), std::string::npos) << reason;
    EXPECT_NEAR(v.factor, factor, 0.2 * factor);
    v.findings = {"noise", "delay"};
    EXPECT_TRUE(contains(verdict_line(v), factor > 1 ? "sigmas are too small by 2." : "sigmas are too large by 2."));
    EXPECT_TRUE(verdict_line(v).ends_with(": noise"));
  }
}

TEST(RunVerdict, WhatIsNotWhiteDoesNotHold) {
  Solution s = run_of();
  end_with(s, Vector3d::Zero());
  add_series(s, 0, 600, 1, 0.6);
  const Verdict v = judge({}, {}, s, nullptr);
  EXPECT_NEAR(v.sources[0].whiteness, 0.6, 0.1);
  EXPECT_GT(v.sources[0].nis_error, std::sqrt(2. / 3 / 600) * 1.1) << "fewer independent values";
  EXPECT_FALSE(v.consistent);
  EXPECT_EQ(verdict_line(v), "sigmas do not hold");
}

TEST(RunVerdict, RestsAndTheFirstSecondsDoNotCount) {
  Solution s = run_of();
  end_with(s, Vector3d::Zero());
  add_series(s, 0, 600, 5);  // from 10 to 70 s
  Log log;
  log.rest = {{0, 65.05}};
  const Verdict v = judge(log, {}, s, nullptr);
  ASSERT_EQ(v.sources.size(), 1U);
  EXPECT_EQ(v.sources[0].fixes, 49U);
}

TEST(RunVerdict, AConstantFarFromItsPriorIsNamed) {
  FilterOptions options;
  options.sensor.gyro.scale = 0.01;
  Solution s = run_of({Block::kGyroScale});
  end_with(s, Vector3d(0.01, -0.06, 0.5));
  const Verdict v = judge({}, options, s, nullptr);
  EXPECT_FALSE(v.consistent);
  ASSERT_EQ(v.jumps.size(), 2U) << "the third is known no better than its prior";
  EXPECT_EQ(v.jumps[0].name, "gyro_scale y");
  EXPECT_NEAR(v.jumps[0].sigmas, -0.06 / std::sqrt(0.01 * 0.01 - 0.002 * 0.002), 1e-9);
}

TEST(RunVerdict, OfNothingIsNothing) {
  const Verdict v = judge({}, {}, run_of(), nullptr);
  EXPECT_TRUE(v.consistent);
  EXPECT_TRUE(v.sources.empty());
  EXPECT_TRUE(v.jumps.empty());
}

TEST(RunVerdict, WhatIsMostlyRejectedDoesNotHold) {
  Solution s = run_of();
  end_with(s, Vector3d::Zero());
  add_series(s, 0, 600, 1);
  for (std::size_t i = 0; i < s.innovations.size(); ++i) {
    if (i % 24 != 0) s.innovations[i].outcome = Outcome::kRejected;
  }
  s.innovations[0].outcome = Outcome::kRepeated;  // no measurement
  const Verdict v = judge({}, {}, s, nullptr);
  EXPECT_FALSE(v.consistent);
  EXPECT_EQ(v.sources[0].fixes, 599U);
  EXPECT_NEAR(v.sources[0].rejected, 575. / 599, 1e-9);
  ASSERT_FALSE(v.sources[0].reasons.empty());
  EXPECT_TRUE(contains(v.sources[0].reasons[0], "96 % of its 599 measurements are rejected; up to 20 % may be"));
  EXPECT_TRUE(std::isnan(v.sources[0].nis)) << "of 25 that were used";
  EXPECT_NEAR(v.factor, 1, 0.1) << "by the median of all";
}

// A receiver whose fixes differ by less than they state may have a slow error: that is said, and no sigma blamed for
// it, unless its user states that its errors are white, or a slow part is stated already.
TEST(RunVerdict, InnovationsCannotTellASlowPart) {
  Solution s = run_of();
  end_with(s, Vector3d::Zero());
  add_series(s, 0, 600, 0.5);
  FilterOptions options;
  options.gnss.emplace_back();
  const Verdict silent = judge({}, options, s, nullptr);
  EXPECT_FALSE(silent.consistent);
  EXPECT_TRUE(silent.slow_part);
  EXPECT_EQ(silent.factor, 1);
  EXPECT_EQ(verdict_line(silent), "sigmas do not hold. " + std::string(kInnovationsCannotTell));
  EXPECT_FALSE(has_too_large_sigmas(silent));

  options.gnss[0].white = true;
  const Verdict white = judge({}, options, s, nullptr);
  EXPECT_FALSE(white.slow_part);
  EXPECT_NEAR(white.factor, 0.5, 0.05);
  EXPECT_TRUE(has_too_large_sigmas(white));

  options.gnss[0].white = false;
  options.gnss[0].drift = PositionDrift::of_share(Vector3d::Constant(0.9), 60);
  const Verdict stated = judge({}, options, s, nullptr);
  EXPECT_TRUE(stated.consistent) << verdict_line(stated);
  EXPECT_FALSE(stated.slow_part);
  Solution large = run_of();
  end_with(large, Vector3d::Zero());
  add_series(large, 0, 600, 2);
  EXPECT_FALSE(judge({}, options, large, nullptr).consistent) << "a slow part makes none larger";
  options.gnss[0].drift = PositionDrift({Vector3d::Ones(), 60});
  EXPECT_FALSE(judge({}, options, s, nullptr).consistent) << "in m it states no share";
}

TEST(RunVerdict, TheWorstSourceHasTheFactor) {
  Solution s = run_of();
  s.sources[1] = "gnss[0].velocity";
  end_with(s, Vector3d::Zero());
  add_series(s, 0, 600, 3);
  add_series(s, 1, 600, 2);
  const Verdict v = judge({}, {}, s, nullptr);
  EXPECT_FALSE(v.sources[1].holds);
  EXPECT_NEAR(v.factor, 3, 0.3);
  EXPECT_FALSE(may_be_slow({GnssOptions{}}, "gnss[0].velocity"));
  EXPECT_TRUE(may_be_slow({GnssOptions{}}, "gnss[0].position"));
}

TEST(RunVerdict, WheelsAndHeightsCountWhereTheyAreLookedAt) {
  const std::vector<std::string> sources{"odometer", "barometer", "heading", "rest.velocity", "gnss[0].position"};
  const Log log;
  const UnderWay fixes(log, sources, 0), measured(log, sources, 0, LookedAt::kMeasured);
  for (int source = 0; source < 5; ++source) {
    const Innovation v = innovation_of(source, 6);
    EXPECT_EQ(fixes.contains(v), source == 4) << sources[static_cast<std::size_t>(source)];
    EXPECT_EQ(measured.contains(v), source != 3) << sources[static_cast<std::size_t>(source)];
  }
  EXPECT_FALSE(measured.contains(innovation_of(4, 4.9)));
  EXPECT_TRUE(measured.contains(innovation_of(4, 4.9, 0.2))) << "the fix came at 5.1 s";
  EXPECT_FALSE(measured.contains(innovation_of(4, 6, 0, Outcome::kRepeated)));
}

TEST(RunVerdict, PriorsOfDelaysAndLeverArmAreThoseStated) {
  FilterOptions options;
  EXPECT_EQ(stated_value(options, Block::kGnssDelay)(0), 0);
  EXPECT_EQ(stated_value(options, Block::kAttitudeDelay)(0), 0);
  options.gnss.push_back({.name = "", .lever_arm = {1, 2, 3}, .delay = 0.1});
  options.attitude.push_back({.name = "", .drift = {}, .delay = 0.3});
  EXPECT_EQ(Vector3d(stated_value(options, Block::kLeverArm).head<3>()), Vector3d(1, 2, 3));
  EXPECT_EQ(stated_value(options, Block::kGnssDelay)(0), 0.1);
  EXPECT_EQ(stated_value(options, Block::kVelocityDelay)(0), 0.1) << "that of the positions";
  EXPECT_EQ(stated_value(options, Block::kAttitudeDelay)(0), 0.3);
}

TEST(RunVerdict, ConstantsAreThoseOfTheSmoother) {
  FilterOptions options;
  options.sensor.gyro.scale = 0.01;
  Solution filtered = run_of({Block::kGyroScale}), smoothed = filtered, none = filtered;
  end_with(filtered, Vector3d(0.06, 0, 0));
  end_with(smoothed, Vector3d(0.01, 0, 0));
  EXPECT_FALSE(judge({}, options, filtered, nullptr).consistent);
  EXPECT_FALSE(judge({}, options, filtered, &none).consistent) << "a smoother that has no row yet";
  const Verdict v = judge({}, options, filtered, &smoothed);
  EXPECT_TRUE(v.consistent);
  EXPECT_NEAR(v.jumps.front().sigmas, 0.01 / std::sqrt(0.01 * 0.01 - 0.002 * 0.002), 1e-9);
}

/// A smoothed track along x at 10 m/s, a row a second, and fixes of two receivers off it.
struct Track {
  Log log;
  FilterOptions options;
  Solution filtered, smoothed;

  explicit Track(std::vector<Block> blocks = {}) {
    filtered = smoothed = Solution(StateLayout(blocks), log.world);
    filtered.sources = {"gnss[0].velocity", "gnss[0].position", "gnss[1].position"};
    log.gnss.resize(2);
    options.gnss.resize(2);
    filtered.append(0, at(0), {});
    for (int i = 0; i <= 40; ++i) smoothed.append(i, at(i), {});
  }
  Estimate at(double time) const {
    Estimate x;
    x.q_wb.setIdentity();
    x.p_wb = Vector3d(10 * time, 0, 0);
    return x;
  }
  /// A fix of the receiver that is `off` sigmas from the track, which the filter compares after `late` seconds.
  void add(std::size_t receiver, double time, const Vector3d& off, Outcome outcome = Outcome::kUsed, double late = 0) {
    const Vector3d p = at(time - late).p_wb, sigma(0.5, 1, 2);
    log.gnss[receiver].push_back({time, p + log.world.rotation_wn(p) * sigma.cwiseProduct(off), sigma, {}});
    filtered.innovations.push_back(innovation_of(static_cast<int>(receiver) + 1, time - late, late, outcome));
  }
  std::vector<double> rms() const {
    SmoothedResiduals r(log, options, filtered);
    r.add(smoothed);
    return r.rms();
  }
  /// The same where rows come in pieces, the first of which is empty.
  std::vector<double> rms_of_pieces() const {
    SmoothedResiduals r(log, options, filtered);
    for (std::size_t i = 0; i <= smoothed.size(); ++i) {
      Solution piece(smoothed.layout(), smoothed.world());
      piece.fixed = smoothed.fixed;
      if (i > 0) piece.append(smoothed.row(i - 1));
      r.add(piece);
    }
    return r.rms();
  }
};

TEST(SmoothedResiduals, AreThoseOfTheFixesThatWereUsedUnderWay) {
  Track t;
  t.log.rest = {{30.2, 35}};
  t.add(0, 0, Vector3d::Constant(50));    // on the first row, and within the first seconds
  t.add(0, 3.5, Vector3d::Constant(50));  // within them
  t.add(0, 7.25, Vector3d(1, 2, -3));
  t.add(0, 9, Vector3d::Zero());  // on a row
  t.add(0, 11.5, Vector3d::Constant(50), Outcome::kRejected);
  t.add(0, 12.5, Vector3d(-3, 0, 0));
  t.add(0, 12.75, Vector3d(0, 2, 0));    // between the same rows
  t.add(0, 32, Vector3d::Constant(50));  // at rest
  t.add(0, 45, Vector3d::Constant(50));  // past the last row
  const double expected = std::sqrt((14. + 0 + 9 + 4) / 4 / 3);
  EXPECT_NEAR(t.rms()[0], expected, 1e-6);
  EXPECT_NEAR(t.rms_of_pieces()[0], expected, 1e-6);
  EXPECT_TRUE(std::isnan(t.rms()[1])) << "no fix";

  add_series(t.filtered, 1, 40, 1);
  const Verdict v = judge(t.log, t.options, t.filtered, &t.smoothed);
  ASSERT_EQ(v.sources.size(), 1U);
  EXPECT_NEAR(v.sources[0].smoothed, expected, 1e-6) << "innovations without a fix in the log tell nothing";
  EXPECT_NEAR(judge(t.log, t.options, t.filtered, &t.smoothed, {7, 8}).sources[0].smoothed, 7, 0);
}

TEST(SmoothedResiduals, KnowWhereTheAntennaIs) {
  // The second receiver has a lever arm that is given, a swaying antenna, a slow error and a delay.
  Track t({Block::kLeverArm});
  t.options.gnss[1].lever_arm = Vector3d(9, 9, 9);
  for (double time = 10.3; time < 30; time += 1) t.add(1, time, Vector3d(0, 0, 1));
  const double free = std::sqrt(1. / 3);
  EXPECT_NEAR(t.rms()[1], free, 1e-6) << "the estimate has the lever arm, and it is zero";

  Track given;
  given.options.gnss[1].lever_arm = Vector3d(0, 0, 2);
  given.options.gnss[1].delay = 0.4;
  for (double time = 10.3; time < 30; time += 1) given.add(1, time, Vector3d(0, 0, 1), Outcome::kUsed, 0.4);
  EXPECT_NEAR(given.rms()[1], 0, 1e-3) << "down turns over some hundred metres";
  EXPECT_NEAR(given.rms_of_pieces()[1], given.rms()[1], 1e-9);

  const Block sway = lever_arm_sway_block(1), drift = position_drift_block(1, true);
  Track moves({sway, drift});
  moves.options.gnss[1].lever_arm_sway = GaussMarkov{Vector3d::Constant(0.1), 1};
  moves.options.gnss[1].drift = PositionDrift::of_share(Vector3d::Constant(0.5), 60);
  moves.smoothed = Solution(moves.smoothed.layout(), moves.log.world);
  for (int i = 0; i <= 40; ++i) {
    Estimate x = moves.at(i);
    additive(x, sway) = Vector3d(0, 1, 0);
    additive(x, drift) = Vector3d(0, 0, 0.25);
    moves.smoothed.append(i, x, {});
  }
  for (double time = 10.3; time < 30; time += 1) {
    moves.add(1, time, Vector3d(0, 1, 0));
    GnssFix& fix = moves.log.gnss[1].back();
    fix.position += moves.log.world.rotation_wn(fix.position) * slow_error(fix, moves.options.gnss[1].drift, 1, [&] {
                      Estimate x;
                      additive(x, drift) = Vector3d(0, 0, 0.25);
                      return x;
                    }());
  }
  EXPECT_NEAR(moves.rms()[1], 0, 1e-4);
}

TEST(SmoothedResiduals, FollowADriftingClock) {
  Track t({Block::kClockDrift});
  t.options.clock_from = 0;
  t.smoothed = Solution(t.smoothed.layout(), t.log.world);
  constexpr double kDrift = 0.01;  // far more than any clock's: 0.3 s in 30 s
  for (int i = 0; i <= 40; ++i) {
    Estimate x = t.at(i);
    x.clock_drift = kDrift;
    t.smoothed.append(i, x, {});
  }
  // At the time t of the track a fix has the time t + delay; the sign is that of the receivers' delay().
  const StateLayout& layout = t.smoothed.layout();
  for (int i = 10; i < 30; ++i) {
    const double late = GnssReceivers::delay(t.options, layout, 0, 0, t.smoothed.estimate(0), i).value;
    EXPECT_GT(std::abs(late), 0.09);
    t.add(0, i + 0.5 + late, Vector3d::Zero(), Outcome::kUsed, late);
  }
  EXPECT_LT(t.rms()[0], 0.3) << "the delay of a row is up to a second old: 10 mm";
  t.options.clock_from = 1000;
  EXPECT_GT(t.rms()[0], 3);
}

}  // namespace
}  // namespace piste::test
