#include "diagnosis/left_out.h"

#include <gtest/gtest.h>

#include "support/text_file.h"

namespace piste::test {
namespace {

// A hundred measurements of a source, a second apart from 100 s on, of which the first ones are left out.
void add(Solution& solution, int source, int rejected, double residual) {
  for (int i = 0; i < 100; ++i) {
    solution.innovations.push_back({.time = 100.0 + i,
                                    .source = source,
                                    .dof = 1,
                                    .residual = {residual, 0, 0},
                                    .sigma = Vector3d::Ones(),
                                    .outcome = i < rejected ? Outcome::kRejected : Outcome::kUsed});
  }
}

TEST(LeftOut, SaysWhichSensorHowOftenAndByHowMuch) {
  Solution solution;
  solution.sources = {"gnss[0].position", "odometer", "heading", "barometer"};
  Log log;
  // A wheel in km/h, at 10 m/s.
  for (int i = 0; i < 100; ++i) log.speed.push_back({100.0 + i, 36, 0.1});
  add(solution, 0, 90, 5);  // a receiver, of which the verdict and its own warnings tell
  add(solution, 1, 95, 26);
  add(solution, 2, 30, 0.5);
  add(solution, 3, 10, 4);  // outliers
  const std::vector<std::string> lines = left_out_lines(log, solution);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_TRUE(contains(lines[0],
                       "odometer: 95 of 100 measurements under way were left out, off by 26 m/s in the "
                       "median, 3.6 times the speed of the run; check its unit"))
      << lines[0];
  EXPECT_TRUE(contains(lines[1], "heading: 30 of 100 measurements under way were left out, off by 28.6 deg"))
      << lines[1];
}

TEST(LeftOut, RestDoesNotCount) {
  Solution solution;
  solution.sources = {"odometer"};
  add(solution, 0, 15, 5);
  EXPECT_TRUE(left_out_lines({}, solution).empty()) << "less than a fifth";
  Log log;
  log.rest = {{130, 300}};  // the others moved
  EXPECT_EQ(left_out_lines(log, solution).size(), 1U);
  log.rest = {{100, 300}};
  EXPECT_TRUE(left_out_lines(log, solution).empty());
}

TEST(LeftOut, SaysThatABaselineStandsUpright) {
  Solution solution;
  solution.sources = {"heading"};
  Log log;
  for (int i = 0; i < 100; ++i) log.heading.push_back({100.0 + i, 1, 0.01});
  const std::vector<std::string> lines = left_out_lines(log, solution);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(contains(lines[0], "its baseline stands upright")) << lines[0];
  add(solution, 0, 0, 0);  // it was compared
  EXPECT_TRUE(left_out_lines(log, solution).empty());
}

}  // namespace
}  // namespace piste::test
