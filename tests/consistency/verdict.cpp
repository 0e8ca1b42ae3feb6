// The verdict of made-up innovations: what holds, what does not, and the line that says so.

#include "piste/consistency/verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "piste/sim/random.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

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

}  // namespace
}  // namespace piste::test
