#include "inspect/clock_leaps.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "piste/inspect/imu_health.h"
#include "support/simulated_case.h"

namespace piste::test {
namespace {

// A ride of two minutes with fixes at 5 Hz, whose clocks are one.
struct Ride {
  ImuRecording imu;
  GnssRecording gnss;
  double middle = 0;

  explicit Ride(std::uint64_t seed) {
    const Case c = make_case("bicycle", 40, seed, [](Scenario& s) {
      s.imus[0].clock_offset = s.imus[0].clock_drift = 0;
      s.motion.run = 120;
    });
    imu = c.simulation.imus[0].recording;
    gnss = c.simulation.gnss[0];
    middle = c.under_way() + 60;
  }
  std::vector<ClockStep> leaps() const {
    return clock_leaps(imu, imu_health(imu).sampling.gaps, gnss, gnss_health(gnss));
  }
};

TEST(ClockLeaps, AStepIsToldFromMissingRows) {
  constexpr double kLeap = 0.9;
  for (const std::uint64_t seed : {4U, 5U}) {
    Ride ride(seed);
    EXPECT_TRUE(ride.leaps().empty());
    const auto first =
        std::lower_bound(ride.imu.time.begin(), ride.imu.time.end(), ride.middle) - ride.imu.time.begin();
    const double before = ride.imu.time[static_cast<std::size_t>(first) - 1];
    Ride missing = ride;
    for (auto time = ride.imu.time.begin() + first; time != ride.imu.time.end(); ++time) *time += kLeap;
    const std::vector<ClockStep> found = ride.leaps();
    ASSERT_EQ(found.size(), 1u) << seed;
    EXPECT_DOUBLE_EQ(found[0].time, before);
    EXPECT_NEAR(found[0].step, kLeap, 1e-3);

    const auto erase = [&](auto& rows) { rows.erase(rows.begin() + first, rows.begin() + first + 90); };
    erase(missing.imu.time);
    erase(missing.imu.gyro);
    erase(missing.imu.accel);
    EXPECT_TRUE(missing.leaps().empty()) << seed;
  }
}

}  // namespace
}  // namespace piste::test
