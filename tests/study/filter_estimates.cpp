#include "study/filter_estimates.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "piste/math/statistics.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste {
namespace {

using test::Case;
using test::make_case;
using test::seeds;

FilterCase filter_case(const Case& c) {
  FilterCase out{c.log(), c.options, c.simulation.plate.under_way()};
  out.options.estimate.clear();
  return out;
}

const MethodEstimate* of(const std::vector<MethodEstimate>& all, Method method) {
  const auto found = std::ranges::find(all, method, &MethodEstimate::method);
  return found == all.end() ? nullptr : &*found;
}

// Errors within 4 of what is claimed, which is at most what is stated here; and their mean square, over the axes and
// the runs, within its band. What a filter says of an instant is cautious for the mean over a run: there it has no
// lower end.
TEST(FilterEstimates, HoldWhatWasPutIn) {
  struct Sums {
    double bias = 0, scale = 0;
  };
  constexpr std::array kEstimators{Method::kMarkovFiltered, Method::kMarkovSmoothed, Method::kWalkSmoothed};
  std::map<Method, Sums> sums;
  const int runs = seeds(2, 10);
  for (int seed = 1; seed <= runs; ++seed) {
    const Case c = make_case("easy_ski", 30, static_cast<std::uint64_t>(seed));
    std::vector<std::string> warnings;
    const std::vector<MethodEstimate> found = filter_estimates(filter_case(c), warnings);
    EXPECT_TRUE(warnings.empty()) << warnings.front();
    EXPECT_EQ(found.size(), 6U) << "three models, filtered and smoothed; there is no reference attitude";
    const SimulatedImu& imu = c.simulation.imus[0];
    for (const Method method : kEstimators) {
      const MethodEstimate* e = of(found, method);
      ASSERT_TRUE(e);
      for (int axis = 0; axis < kSignals; ++axis) {
        SCOPED_TRACE(
            fmt::format("{} {}, seed {}", info(method).name, kSignalNames[static_cast<std::size_t>(axis)], seed));
        const TriadDraw& truth = axis < 3 ? imu.accel : imu.gyro;
        const BiasScale& line = *e->axes[static_cast<std::size_t>(axis)].line;
        const double bias = (line.value(0) - truth.bias(axis % 3) - truth.run.drift(axis % 3)) / line.bias().total(),
                     scale = (line.value(1) - truth.scale(axis % 3)) / line.scale().total();
        EXPECT_LT(std::abs(bias), 4);
        EXPECT_LT(std::abs(scale), 4);
        const double room = method == Method::kMarkovFiltered ? 2.6 : 1;
        EXPECT_LT(line.bias().total(), room * (axis < 3 ? 0.023 : 2.2e-4));
        EXPECT_LT(line.scale().total(), room * 2.7e-3);
        EXPECT_LT(std::abs(line.correlation()), 1);
        sums[method].bias += bias * bias / (kSignals * runs);
        sums[method].scale += scale * scale / (kSignals * runs);
      }
    }
    // The smoother knows what comes after the run.
    for (std::size_t axis = 0; axis < kSignals; ++axis) {
      EXPECT_LT(of(found, Method::kMarkovSmoothed)->axes[axis].line->bias().total(),
                of(found, Method::kMarkovFiltered)->axes[axis].line->bias().total());
    }
  }
  const Band band = chi_squared_band(0.999, 1, kSignals * runs);
  for (const Method method : kEstimators) {
    for (const double nees : {sums[method].bias, sums[method].scale}) {
      EXPECT_LT(nees, band.high) << info(method).name;
      if (method != Method::kMarkovFiltered) {
        EXPECT_GT(nees, band.low) << info(method).name;
      }
    }
  }
}

TEST(FilterEstimates, ASensorWithoutDriftIsAConstantByEveryModel) {
  const Case c = make_case("easy_ski", 30, 1, [](Scenario& s) { s.motion.run = 40; });
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
  const Case c = make_case("easy_ski", 30, 1, [](Scenario& s) { s.motion.run = 40; });
  FilterCase given = filter_case(c);
  given.log.gnss[0].clear();
  std::vector<std::string> warnings;
  EXPECT_TRUE(filter_estimates(given, warnings).empty());
  EXPECT_EQ(warnings.size(), 3U) << "one a model";
}

}  // namespace
}  // namespace piste
