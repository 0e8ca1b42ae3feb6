#include "search/calibration.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/recording.h"
#include "piste/math/statistics.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

// What the motion tells of where the antenna sits, from nothing.
TEST(Calibration, FindsTheLeverArmFromTheMotion) {
  struct Motion {
    const char* name;
    double largest_sigma;  // m
  };
  for (const auto& [motion, largest_sigma] : {Motion{"easy_ski", 0.006}, {"ski", 0.015}}) {
    const int runs = seeds(2, 20);
    double nees = 0;
    for (int seed = 1; seed <= runs; ++seed) {
      Case c = make_case(motion, 40, static_cast<std::uint64_t>(seed));
      const Vector3d truth = c.options.gnss[0].lever_arm;
      c.options.gnss[0].lever_arm.setZero();
      const auto found = calibrate(c.simulation.recording(0), c.conditioning, c.options, {0.01});
      ASSERT_TRUE(found) << "seed " << seed;
      const Calibration& guess = *found;
      const Vector3d error = guess.lever_arm - truth;
      nees += error.cwiseQuotient(guess.lever_arm_sigma).squaredNorm() / (3 * runs);
      fmt::print(
          "{}: lever arm {:.3f} {:.3f} {:.3f} ± {:.3f} {:.3f} {:.3f} m, off by {:.3f} {:.3f} {:.3f}; {} used, {} "
          "rejected\n",
          motion, guess.lever_arm.x(), guess.lever_arm.y(), guess.lever_arm.z(), guess.lever_arm_sigma.x(),
          guess.lever_arm_sigma.y(), guess.lever_arm_sigma.z(), error.x(), error.y(), error.z(), guess.used,
          guess.rejected);
      EXPECT_LT(guess.lever_arm_sigma.maxCoeff(), largest_sigma);
      EXPECT_LT(guess.rejected, guess.used / 20);
    }
    const Band band = chi_squared_band(0.999, 3, runs);
    fmt::print("{}: NEES {:.2f}, band {:.2f} to {:.2f}\n", motion, nees, band.low, band.high);
    EXPECT_TRUE(band.contains(nees)) << motion << ": " << nees;
  }
}

// An antenna that is not on the body.
TEST(Calibration, OfAnAntennaFourMetresAwayShows) {
  for (int i = 1; i <= seeds(1, 4); ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    Case c = make_case("easy_ski", 40, seed, [](Scenario& s) { s.gnss[0].p_ra_r += Vector3d(4, 0, 0); });
    const Vector3d truth = c.options.gnss[0].lever_arm;
    c.options.gnss[0].lever_arm.setZero();
    const auto found = calibrate(c.simulation.recording(0), c.conditioning, c.options, {0.01});
    ASSERT_TRUE(found) << "seed " << seed;
    const Calibration& guess = *found;
    fmt::print("off {:.2f} m, sigma {:.3f} m, value {:.2f} m, {} used {} rejected\n", (guess.lever_arm - truth).norm(),
               guess.lever_arm_sigma.maxCoeff(), guess.lever_arm.norm(), guess.used, guess.rejected);
    EXPECT_GT(guess.lever_arm.norm(), 1);
  }
}

// Velocities of 10 Hz, integrated over 0.4 s by trapezoids: as a receiver has them that smooths.
TEST(Calibration, VelocitiesThatAreMeansShow) {
  Case c = make_case("ski", 40, 6);
  Recording recording = c.simulation.recording(0);
  std::vector<GeodeticFix>& fixes = recording.gnss.front().fixes;
  ASSERT_NEAR(fixes[1].time - fixes[0].time, 0.1, 1e-6);
  const auto as_given = calibrate(recording, c.conditioning, c.options, {0.01});
  ASSERT_TRUE(as_given);
  EXPECT_EQ(as_given->velocity_averaging, 0);
  const std::vector<GeodeticFix> of_the_moment = fixes;
  for (std::size_t i = 2; i + 2 < fixes.size(); ++i) {
    const auto at = [&](std::size_t k) { return of_the_moment[k].velocity->value; };
    fixes[i].velocity->value = (at(i - 2) / 2 + at(i - 1) + at(i) + at(i + 1) + at(i + 2) / 2) / 4;
  }
  const auto found = calibrate(recording, c.conditioning, c.options, {0.01});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->velocity_averaging, 0.4);
}

// As in a phone: fixes of metres tell little of the lever arm, and it stays where the housing has it.
TEST(Calibration, InOneHousingTheLeverArmStaysShort) {
  Case c = make_case("bicycle", 40, 3, [](Scenario& s) {
    s.gnss[0].position_noise = s.gnss[0].position_noise.normalized() * 3;
    s.gnss[0].velocity_noise = s.gnss[0].velocity_noise.normalized() * 0.5;
  });
  c.options.gnss[0].lever_arm.setZero();
  const auto near_by = calibrate(c.simulation.recording(0), c.conditioning, c.options, {0.01});
  const auto housed = calibrate(c.simulation.recording(0), c.conditioning, c.options, {0.01}, Antenna::kInHousing);
  ASSERT_TRUE(near_by && housed);
  EXPECT_FALSE(near_by->in_housing);
  EXPECT_TRUE(housed->in_housing);
  EXPECT_GT(near_by->lever_arm_sigma.maxCoeff(), kHousing);
  EXPECT_LE(housed->lever_arm_sigma.maxCoeff(), kHousing);
  EXPECT_EQ(priors_after(*housed).lever_arm, kHousing);
}

// A clock that is off by more than is tried: what a filter makes of it is as likely as with any other wrong clock. At
// 50 Hz this ride makes it likelier than all of them by chance, until the noise is that which explains it.
TEST(Calibration, AClockThatNothingTellsIsNotMadeUp) {
  const ToldClock untold{std::numeric_limits<double>::infinity()};
  const auto ride = [](double rate) {
    return make_case("bicycle", 40, 5, [rate](Scenario& s) {
      s.imus[0].rate = rate;
      s.motion.run = 90;
      s.motion.cycle = 60;
    });
  };
  for (const double rate : {100.0, 50.0}) {
    const Case c = ride(rate);
    ConditioningOptions off = c.conditioning;
    off.imu.clock_offset -= 12;
    EXPECT_FALSE(calibrate(c.simulation.recording(0), off, c.options, untold)) << rate << " Hz";
  }
  const Case c = ride(100);
  const auto found = calibrate(c.simulation.recording(0), c.conditioning, c.options, untold);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->clock_offset, c.conditioning.imu.clock_offset, 4 * found->clock_sigma);
}

// A receiver that states a thousand times its errors would tell nothing of the clock: that is sought with smaller
// sigmas. What is stated stays, as an error of that size may last.
TEST(Calibration, SigmasThatAreFarTooLargeAreMadeSmallerFirst) {
  constexpr double kTooLarge = 1000;
  const Case c = make_case("bicycle", 40, 5, [](Scenario& s) {
    s.motion.run = 90;
    s.gnss[0].velocity_noise.setZero();
  });
  Recording overstated = c.simulation.recording(0);
  scale_sigmas(overstated.gnss.front().fixes, {.position = kTooLarge});
  const ToldClock untold{std::numeric_limits<double>::infinity()};
  const auto found = calibrate(overstated, c.conditioning, c.options, untold);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->clock_offset, c.conditioning.imu.clock_offset, 0.02);
  EXPECT_NEAR(found->sigma_scales.position, 1, 1e-6);
  ASSERT_TRUE(found->drift && found->drift->of_stated);
  const double white = std::sqrt(1 - found->drift->sigma.x() * found->drift->sigma.x());
  EXPECT_LT(white * kTooLarge, 5) << "times the true noise";
}

}  // namespace
}  // namespace piste::test
