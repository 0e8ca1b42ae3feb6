// Fixes of a standstill as fewer ones, which tell as much.

#include "start/merged_fixes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "support/random.h"

namespace piste::test {
namespace {

/// Ten fixes a second over 30 s, of which the body stands from 10 to 20 s.
Log log_of_a_rest() {
  Log log;
  Random random(1);
  log.rest = {{10, 20}};
  log.gnss.resize(1);
  for (int i = 0; i < 300; ++i) {
    log.gnss[0].push_back({0.1 * i + 0.05, Vector3d(1, 2, 3) + random.vector(0.1), Vector3d::Constant(0.1),
                           FixVelocity{random.vector(0.2), Vector3d::Constant(0.2)}});
  }
  return log;
}

std::vector<GnssFix> merged(const std::function<void(std::vector<GnssFix>&)>& change = {}, double step = 1) {
  Log log = log_of_a_rest();
  if (change) change(log.gnss[0]);
  return with_merged_fixes(log, 100, step).gnss[0];
}

TEST(MergedFixes, AreMeansOfASecondAtRest) {
  const std::vector<GnssFix> fixes = merged();
  ASSERT_EQ(fixes.size(), 210U) << "a hundred before and after, and ten";
  const std::vector<GnssFix> all = log_of_a_rest().gnss[0];
  Vector3d mean = Vector3d::Zero(), velocity = Vector3d::Zero();
  for (std::size_t i = 100; i < 110; ++i) {
    mean += 0.1 * all[i].position;
    velocity += 0.1 * all[i].velocity->value;
  }
  const GnssFix& first = fixes[100];
  EXPECT_EQ(first.time, all[109].time);
  EXPECT_LT((first.position - mean).norm(), 1e-12);
  EXPECT_LT((first.velocity->value - velocity).norm(), 1e-12);
  EXPECT_NEAR(first.sigma_position.x(), 0.1 / std::sqrt(10), 1e-12);
  EXPECT_NEAR(first.velocity->sigma.x(), 0.2 / std::sqrt(10), 1e-12);
  EXPECT_EQ(fixes[99].position, all[99].position);
  EXPECT_EQ(fixes[110].position, all[200].position);
}

TEST(MergedFixes, WeighByTheirSigmas) {
  const std::vector<GnssFix> fixes = merged([](auto& all) {
    for (std::size_t i = 100; i < 110; i += 2) {
      all[i].position.x() += 1000;
      all[i].sigma_position.setConstant(1e4);
    }
    all[103].slow_change = Vector3d(0.1, 0.2, 0.3);
    all[104].slow_change = Vector3d(0.1, 0.1, 0.1);
  });
  EXPECT_NEAR(fixes[100].position.x(), 1, 0.2);
  EXPECT_NEAR(fixes[100].sigma_position.x(), 0.1 / std::sqrt(5), 1e-6);
  EXPECT_LT((fixes[100].slow_change - Vector3d(0.2, 0.3, 0.4)).norm(), 1e-12) << "what may have changed adds up";
}

// One of another kind begins a mean of its own, as does the one after it.
TEST(MergedFixes, AreOfOneKind) {
  const auto count = [](const std::function<void(GnssFix&)>& change) {
    return merged([&](auto& all) { change(all[105]); }).size();
  };
  EXPECT_EQ(count([](GnssFix&) {}), 210U);
  EXPECT_EQ(count([](GnssFix& f) { f.quality = FixQuality::kFixed; }), 212U) << "a second begins with each anew";
  EXPECT_EQ(count([](GnssFix& f) { f.runs_away = true; }), 212U);
  EXPECT_EQ(count([](GnssFix& f) { f.velocity.reset(); }), 212U);
  EXPECT_EQ(count([](GnssFix& f) { f.velocity->sigma.z() = std::numeric_limits<double>::infinity(); }), 212U);
  const auto none = [](auto& all) {
    for (GnssFix& f : all) f.velocity.reset();
  };
  EXPECT_EQ(merged(none).size(), 210U);
  EXPECT_FALSE(merged(none)[100].velocity);
}

TEST(MergedFixes, LaterOnesAreLeftOut) {
  const Log log = log_of_a_rest();
  const std::vector<GnssFix> fixes = with_merged_fixes(log, 5, 1).gnss[0];
  EXPECT_NEAR(fixes.back().time, 7, 0.1) << "but for some that may come late";
}

}  // namespace
}  // namespace piste::test
