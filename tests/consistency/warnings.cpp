#include "piste/consistency/warnings.h"

#include <gtest/gtest.h>

#include "support/text_file.h"

namespace piste::test {
namespace {

// So many measurements of a source, a second apart, of which the first ones are rejected.
void add(Solution& solution, int source, int all, int rejected) {
  for (int i = 0; i < all; ++i) {
    solution.innovations.push_back({.time = static_cast<double>(i),
                                    .source = source,
                                    .residual = {3, 4, 0},
                                    .sigma = Vector3d::Ones(),
                                    .outcome = i < rejected ? Outcome::kRejected : Outcome::kUsed});
  }
}

TEST(Warnings, OfReceiversThatContradictedTheRest) {
  Solution solution;
  solution.sources = {"gnss[0].position", "attitude[0]", "gnss[1].position"};
  add(solution, 0, 100, 2);   // outliers
  add(solution, 1, 100, 21);  // no receiver
  add(solution, 2, 100, 6);
  const std::vector<std::string> warnings = warnings_of(solution);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "gnss[1].position contradicted the rest, by 5 m at first")) << "over 5 s";
}

TEST(Warnings, ManyOfOneSourceAreToldTogether) {
  Solution solution;
  solution.sources = {"gnss[0].position", "gnss[0].velocity"};
  for (int times = 0; times < 9; ++times) {
    add(solution, 0, 20, 6);
    for (Innovation& i : solution.innovations) i.time += i.source == 0 ? 20 : 0;
  }
  add(solution, 1, 100, 6);
  const std::vector<std::string> warnings = warnings_of(solution);
  ASSERT_EQ(warnings.size(), 7U);
  EXPECT_TRUE(contains(warnings.back(), "gnss[0].position was left out 4 more times until")) << warnings.back();
  EXPECT_TRUE(contains(warnings.back(), ", 24 fixes in all of them")) << warnings.back();
}

TEST(Warnings, NoneOfARunThatWentWell) {
  Solution solution;
  solution.sources = {"gnss[0].position"};
  add(solution, 0, 100, 0);
  EXPECT_TRUE(warnings_of(solution).empty());
}

TEST(Warnings, OfImusThatWereLeftOut) {
  ImuReport whole{.name = "a"}, parts{.name = "b", .left_out = 7};
  parts.absences = {{.fault = ImuFault::kSpike, .time = {3, 4}},  {.fault = ImuFault::kClipped, .time = {1, 2}},
                    {.fault = ImuFault::kSpike, .time = {8, 9}},  {.fault = ImuFault::kStuck, .time = {5, 6}},
                    {.fault = ImuFault::kSilent, .time = {6, 7}}, {.fault = ImuFault::kBiased, .time = {7, 8}}};
  const std::vector<std::string> lines = absence_lines({whole, parts});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(
      lines[0],
      "IMU b was left out in 7 epochs: clipped once, first from 1.000 to 2.000 s; stuck once, first from 5.000 to "
      "6.000 s; spike 2 times, first from 3.000 to 4.000 s; silent once, first from 6.000 to 7.000 s; biased once, "
      "first from 7.000 to 8.000 s");
}

TEST(Warnings, WhatAnAdaptiveFilterAndTheBatchSay) {
  const AdaptedNoise adapted{.names = {"gnss[0].position", "gyro_noise"}, .time = {1, 2}, .factors = {1, 2, 4, 2}};
  EXPECT_EQ(adapted_line(adapted), "adapted sigmas: gnss[0].position times 2 (1 to 4), gyro_noise times 2 (2 to 2)");
  const BatchSummary batch{.nodes = 10, .fixes = 9, .left_out = 2, .taken_back = 1, .rounds = 3, .iterations = 8};
  EXPECT_TRUE(contains(batch_line(batch), "10 nodes, 9 fixes, of which 2 were left out and 1 that"));
  EXPECT_TRUE(contains(batch_line(batch), "NOT CONVERGED in 3 rounds, 8 steps"));
}

}  // namespace
}  // namespace piste::test
