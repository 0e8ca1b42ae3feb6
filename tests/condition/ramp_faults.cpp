// Positions that run away from the receiver's own velocities.

#include "condition/ramp_faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/random.h"

namespace piste {
namespace {

const World kHere(Geodetic{0.8, 0.1, 500});
const Vector3d kAside = Vector3d(0.6, -0.7, 0.39).normalized();
constexpr double kBegin = 80, kLength = 30;  // s of the fault

struct Receiver {
  double rate = 10;                   // Hz
  double sigma = 0.02, speed = 0.03;  // stated of positions [m] and of velocities [m/s], white
  double truly = 1;                   // times as large as they are stated
  double late = 0;                    // of velocities [s]
  double wander = 0, time = 30;       // of a slow error within the stated sigma [m], [s]
};

// A body that swings to and fro downhill at some 12 m/s for 200 s.
std::vector<GnssFix> descent(const Receiver& r, std::uint64_t seed) {
  test::Random random(seed);
  const auto place = [](double t) { return Vector3d(10 * t, 8 * std::sin(1.2 * t), 2 * t); };
  const auto velocity = [](double t) { return Vector3d(10, 9.6 * std::cos(1.2 * t), 2); };
  const double stated = std::hypot(r.sigma, r.wander);
  Vector3d slow = random.vector(r.wander);
  std::vector<GnssFix> fixes;
  for (int i = 0; i < 200 * r.rate; ++i) {
    const double t = i / r.rate, kept = std::exp(-1 / (r.rate * r.time));
    slow = kept * slow + random.vector(r.wander * std::sqrt(1 - kept * kept));
    const Vector3d v = velocity(t - r.late) + r.truly * random.vector(r.speed);
    fixes.push_back({1000 + t, place(t) + r.truly * random.vector(r.sigma) + slow, Vector3d::Constant(stated),
                     FixVelocity{v, Vector3d::Constant(r.speed)}});
  }
  return fixes;
}

void run_away(std::vector<GnssFix>& fixes, double speed, double length = kLength) {
  for (GnssFix& f : fixes) {
    const double since = f.time - 1000 - kBegin;
    if (since >= 0 && since < length) f.position += speed * since * kAside;
  }
}

std::vector<RampFault> found_in(std::vector<GnssFix>& fixes) { return exclude_ramp_faults(fixes, {}, kHere); }

// All of the fault but its first part, which nobody can tell from noise, and nothing that is well before it.
TEST(RampFaults, AreExcludedFromTheirBeginningToTheirEnd) {
  for (const Receiver& r : {Receiver{}, Receiver{.rate = 4}, Receiver{.late = 0.08}, Receiver{.truly = 3}}) {
    for (const double speed : {0.1, 0.3}) {
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        auto fixes = descent(r, seed);
        run_away(fixes, speed);
        const auto found = found_in(fixes);
        EXPECT_EQ(found.size(), 1u) << r.rate << " " << r.late << " " << r.truly << " " << speed << " " << seed;
        if (found.empty()) continue;
        const double tolerated = 4 * r.truly * r.sigma / speed;
        EXPECT_GT(found[0].span.start, 1000 + kBegin - kLength / 2);
        EXPECT_LT(found[0].span.start, 1000 + kBegin + tolerated)
            << r.rate << " " << r.late << " " << r.truly << " " << speed << " " << seed;
        EXPECT_NEAR(found[0].span.end, 1000 + kBegin + kLength, 1.5 / r.rate) << speed << " " << seed;
        EXPECT_NEAR(found[0].off, speed * kLength, 0.1 + 3 * r.truly * r.sigma + 0.1 * speed * kLength);
        for (const GnssFix& f : fixes) EXPECT_EQ(f.runs_away, found[0].span.contains(f.time));
      }
    }
  }
}

TEST(RampFaults, AreNotSeenInHonestReceivers) {
  for (const Receiver& r :
       {Receiver{}, Receiver{.rate = 1}, Receiver{.sigma = 0.4, .speed = 0.1, .wander = 0.4}, Receiver{.late = 0.13},
        Receiver{.rate = 4, .sigma = 3, .speed = 0.3, .wander = 2}, Receiver{.truly = 4}}) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
      auto fixes = descent(r, seed);
      EXPECT_TRUE(found_in(fixes).empty())
          << r.rate << " " << r.sigma << " " << r.late << " " << r.truly << " " << seed;
    }
  }
}

// Nor does one fix in ten that is metres off look like one, beside velocities that come late.
TEST(RampFaults, AreNotSeenInOutliers) {
  for (const double late : {0.0, 0.1}) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      auto fixes = descent({.late = late}, seed);
      test::Random random(seed + 1000);
      for (GnssFix& f : fixes) {
        if (random.uniform() < 0.1) f.position += (2 + 98 * random.uniform()) * random.vector().normalized();
      }
      EXPECT_TRUE(found_in(fixes).empty()) << late << " " << seed;
    }
  }
}

// Who is at fault is not known where positions and velocities do not meet again; and a jump is the filter's.
TEST(RampFaults, AreLeftToTheFilterWhereTheyDoNotReturnOrLeap) {
  auto fixes = descent({}, 1);
  for (GnssFix& f : fixes) {
    if (f.time > 1000 + kBegin) f.velocity->value.x() += 0.2;
  }
  EXPECT_TRUE(found_in(fixes).empty()) << "the velocities may be wrong";
  fixes = descent({}, 1);
  for (GnssFix& f : fixes) {
    if (f.time > 1000 + kBegin && f.time < 1000 + kBegin + kLength) f.velocity->value.x() += 0.2;
  }
  EXPECT_TRUE(found_in(fixes).empty()) << "they were wrong";
  fixes = descent({}, 1);
  for (GnssFix& f : fixes) {
    if (f.time > 1000 + kBegin && f.time < 1000 + kBegin + kLength) f.position += 3 * kAside;
  }
  EXPECT_TRUE(found_in(fixes).empty()) << "a jump";
  fixes = descent({}, 1);
  run_away(fixes, 0.3);
  for (GnssFix& f : fixes) f.velocity.reset();
  EXPECT_TRUE(found_in(fixes).empty()) << "no velocities";
  std::vector<GnssFix> none;
  EXPECT_TRUE(found_in(none).empty());
}

// Fixes that are repeated, velocities without down and an outage before it do not hide it.
TEST(RampFaults, AreSeenInReceiversOfEveryKind) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto whole = [] {
    auto fixes = descent({}, 1);
    run_away(fixes, 0.3);
    return fixes;
  };
  auto fixes = whole();
  for (std::size_t i = 1; i < fixes.size(); i += 3) {
    fixes[i].position = fixes[i - 1].position;
    fixes[i].velocity = fixes[i - 1].velocity;
  }
  ASSERT_EQ(found_in(fixes).size(), 1u) << "repeated";
  fixes = whole();
  for (GnssFix& f : fixes)
    f.velocity = FixVelocity{{f.velocity->value.x(), f.velocity->value.y(), 0}, {0.03, 0.03, kInfinity}};
  ASSERT_EQ(found_in(fixes).size(), 1u) << "without down";
  for (const bool silent : {true, false}) {
    fixes = whole();
    // It begins two seconds after fixes or velocities are there again: before that nobody knows.
    const auto out = [](const GnssFix& f) { return f.time > 1000 + kBegin - 12 && f.time < 1000 + kBegin - 2; };
    if (silent) std::erase_if(fixes, out);
    for (GnssFix& f : fixes) {
      if (out(f)) f.velocity.reset();
    }
    const auto found = found_in(fixes);
    ASSERT_EQ(found.size(), 1u) << silent;
    EXPECT_GT(found[0].span.start, 1000 + kBegin - 2);
    EXPECT_LT(found[0].span.start, 1000 + kBegin + 1);
  }
}

// Positions that do not return for as long as a receiver is distrusted are left to the filter, which believes them
// then.
TEST(RampFaults, AreNotWaitedForLongerThanAReceiverIsDistrusted) {
  auto fixes = descent({}, 1);
  run_away(fixes, 0.3);
  EXPECT_TRUE(exclude_ramp_faults(fixes, {.distrust = 0.5 * kLength}, kHere).empty());
  EXPECT_EQ(exclude_ramp_faults(fixes, {.distrust = 1.2 * kLength}, kHere).size(), 1u);
  std::erase_if(fixes, [](const GnssFix& f) { return f.time > 1000 + kBegin + kLength - 1; });
  EXPECT_TRUE(found_in(fixes).empty()) << "the log ends before it returns";
}

}  // namespace
}  // namespace piste
