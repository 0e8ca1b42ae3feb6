// What the offsets of single stretches say of a clock.

#include "condition/clock_evenness.h"

#include <gtest/gtest.h>

#include "support/random.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

std::vector<LocalOffset> offsets(double wander, std::size_t count, Random& random) {
  std::vector<LocalOffset> all;
  for (std::size_t i = 0; i < count; ++i) {
    const double sigma = (0.2 + 0.8 * random.uniform()) * 1e-3;
    all.push_back({10.0 * static_cast<double>(i), random.gaussian(std::hypot(wander, sigma)), sigma});
  }
  return all;
}

TEST(ClockWander, NoiseIsNoWander) {
  Random random(1);
  for (int run = 0; run < 200; ++run) EXPECT_EQ(clock_wander(offsets(0, 30, random), "log"), 0) << run;
}

TEST(ClockWander, IsWhatTheOffsetsScatterBeyondTheirNoise) {
  Random random(2);
  double mean = 0;
  constexpr int kRuns = 100;
  for (int run = 0; run < kRuns; ++run) mean += std::pow(clock_wander(offsets(2e-3, 60, random), "log"), 2) / kRuns;
  EXPECT_NEAR(std::sqrt(mean), 2e-3, 0.1e-3);
}

// The fit has taken an offset and a drift out of them: of ten offsets, eight are free.
TEST(ClockWander, IsUnbiasedInShortLogs) {
  Random random(4);
  double mean = 0;
  constexpr int kRuns = 1000;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<LocalOffset> few = offsets(1.5e-3, 10, random);
    const double offset = random.gaussian(1e-3), drift = random.gaussian(1e-5);
    for (LocalOffset& l : few) l.offset += offset + drift * l.time;
    mean += std::pow(clock_wander(few, "log"), 2) / kRuns;
  }
  EXPECT_NEAR(std::sqrt(mean), 1.5e-3, 0.04e-3);
}

TEST(ClockWander, RefusesAStretchThatStandsOutAndAWanderOfManyMilliseconds) {
  Random random(3);
  std::vector<LocalOffset> jump = offsets(0, 30, random);
  jump[7].offset = 0.025;
  EXPECT_TRUE(contains(message_of<DataError>([&] { clock_wander(jump, "log"); }), "about 70.0 s it is 25.0 ms"));
  const auto wild = [&] { clock_wander(offsets(8e-3, 30, random), "log"); };
  EXPECT_TRUE(contains(message_of<DataError>(wild), "log: the clock of the body IMU does not run evenly"));
}

}  // namespace
}  // namespace piste::test
