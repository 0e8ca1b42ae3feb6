#include "experiment/filter_estimates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/simulated_case.h"

namespace piste {
namespace {

using test::Case;
using test::make_case;

FilterCase filter_case(const Case& c) {
  FilterCase out{c.log(), c.options, c.simulation.plate.under_way()};
  out.options.estimate.clear();
  return out;
}

const MethodEstimate* of(const std::vector<MethodEstimate>& all, Method method) {
  const auto found = std::ranges::find(all, method, &MethodEstimate::method);
  return found == all.end() ? nullptr : &*found;
}

TEST(FilterEstimates, HoldWhatWasPutIn) {
  const Case c = make_case("easy_ski", 30, 4);
  std::vector<std::string> warnings;
  const std::vector<MethodEstimate> found = filter_estimates(filter_case(c), warnings);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  EXPECT_EQ(found.size(), 6U) << "three models, filtered and smoothed; there is no reference attitude";
  const SimulatedImu& imu = c.simulation.imus[0];
  for (const Method method : {Method::kMarkovFiltered, Method::kMarkovSmoothed, Method::kWalkSmoothed}) {
    const MethodEstimate* e = of(found, method);
    ASSERT_TRUE(e);
    for (int axis = 0; axis < kSignals; ++axis) {
      const TriadDraw& truth = axis < 3 ? imu.accel : imu.gyro;
      const BiasScale& line = *e->axes[static_cast<std::size_t>(axis)].line;
      const double bias = truth.bias(axis % 3) + truth.run.drift(axis % 3), scale = truth.scale(axis % 3);
      EXPECT_LT(std::abs(line.value(0) - bias), 4 * line.bias().total()) << info(method).name << kSignalNames[axis];
      EXPECT_LT(std::abs(line.value(1) - scale), 4 * line.scale().total()) << info(method).name << kSignalNames[axis];
      EXPECT_LT(std::abs(line.correlation()), 1);
    }
  }
  // The smoother knows what comes after the run.
  for (std::size_t axis = 0; axis < kSignals; ++axis) {
    EXPECT_LT(of(found, Method::kMarkovSmoothed)->axes[axis].line->bias().total(),
              of(found, Method::kMarkovFiltered)->axes[axis].line->bias().total());
  }
}

TEST(FilterEstimates, ASensorWithoutDriftIsAConstantByEveryModel) {
  const Case c = make_case("easy_ski", 30, 4, [](Scenario& s) { s.motion.run = 40; });
  FilterCase given = filter_case(c);
  given.options.sensor.gyro.drift = given.options.sensor.accel.drift = {};
  given.options.sensor.gyro.scale = 0;
  std::vector<std::string> warnings;
  const std::vector<MethodEstimate> found = filter_estimates(given, warnings);
  ASSERT_EQ(found.size(), 6U);
  const AxisEstimate &constant = of(found, Method::kConstantSmoothed)->axes[5],
                     &markov = of(found, Method::kMarkovSmoothed)->axes[5];
  EXPECT_EQ(constant.bias_alone->value, markov.bias_alone->value) << "no scale is estimated";
  EXPECT_FALSE(constant.line);
}

TEST(FilterEstimates, WhatCannotBeHadIsSaid) {
  const Case c = make_case("easy_ski", 30, 4, [](Scenario& s) { s.motion.run = 40; });
  FilterCase given = filter_case(c);
  given.log.gnss[0].clear();
  std::vector<std::string> warnings;
  EXPECT_TRUE(filter_estimates(given, warnings).empty());
  EXPECT_EQ(warnings.size(), 3U) << "one a model";
}

}  // namespace
}  // namespace piste
