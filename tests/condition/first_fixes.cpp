// First fixes that the later ones contradict.

#include "condition/first_fixes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "support/random.h"

namespace piste {
namespace {

const World kWorld(Geodetic{0.8, 0.1, 500});

// A body that rests for 20 s and then drives a circle of 30 m, soon at 10 m/s, with fixes of 1 cm at `rate`.
std::vector<GnssFix> circle(double rate, double sigma = 0.01) {
  test::Random random(3);
  std::vector<GnssFix> fixes;
  for (int i = 0; i < 120 * rate; ++i) {
    const double t = i / rate, moving = std::max(0.0, t - 20);
    const double angle = moving < 5 ? moving * moving / 30 : (moving - 2.5) / 3;
    const Vector3d place(30 * std::sin(angle), 30 - 30 * std::cos(angle), 0);
    const Vector3d error = sigma * Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
    fixes.push_back({1000 + t, place + error, Vector3d::Constant(sigma), std::nullopt});
  }
  return fixes;
}

void move(std::vector<GnssFix>& fixes, double from, double to, const Vector3d& by) {
  for (GnssFix& f : fixes) {
    if (f.time >= 1000 + from && f.time < 1000 + to) f.position += by;
  }
}

TEST(FirstFixes, AreAsUncertainAsTheyAreOff) {
  for (const double rate : {1.0, 10.0}) {
    for (const double until : {2.5, 10.0}) {
      auto fixes = circle(rate);
      move(fixes, 0, until, Vector3d(20, 0, -4));
      const FirstFixes found = widen_first_fixes(fixes, {}, kWorld);
      ASSERT_EQ(found.count, static_cast<std::size_t>(std::ceil(until * rate))) << rate << " " << until;
      EXPECT_NEAR(found.off, Vector3d(20, 0, -4).norm(), rate > 1 ? 0.3 : 8);
      EXPECT_NEAR(fixes[0].sigma_position.norm() / std::sqrt(static_cast<double>(found.count)), found.off, 0.01);
      EXPECT_EQ(fixes[found.count].sigma_position, Vector3d::Constant(0.01));
    }
  }
}

TEST(FirstFixes, AreLeftAloneElsewhere) {
  const auto count = [](std::vector<GnssFix> fixes) { return widen_first_fixes(fixes, {}, kWorld).count; };
  const Vector3d by(20, 0, -4);
  auto fixes = circle(10);
  EXPECT_EQ(count(fixes), 0u);
  move(fixes, 5, 12, by);
  EXPECT_EQ(count(fixes), 0u) << "it comes back";
  fixes = circle(10);
  move(fixes, 30, 60, by);
  EXPECT_EQ(count(fixes), 0u) << "as long as where it began";
  fixes = circle(1, 3);
  move(fixes, 0, 5, by);
  EXPECT_EQ(count(fixes), 0u) << "within the sigmas";
  fixes = circle(10);
  move(fixes, 3, 3.05, by);
  EXPECT_EQ(count(fixes), 0u) << "one outlier";
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed);
    fixes = circle(10);
    for (GnssFix& f : fixes) {
      if (random.uniform() < 0.1) f.position.z() += 100 * (random.uniform() - 0.5);
    }
    EXPECT_EQ(count(fixes), 0u) << "one in ten is an outlier " << seed;
  }
  EXPECT_EQ(count({}), 0u);
}

}  // namespace
}  // namespace piste
