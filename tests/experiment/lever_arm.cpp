#include "experiment/lever_arm.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "piste/math/statistics.h"
#include "support/simulated_case.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

// What the motion tells of where the antenna sits, from nothing.
TEST(LeverArm, IsFoundFromTheMotion) {
  struct Motion {
    const char* name;
    double largest_sigma;  // m
  };
  for (const auto& [motion, largest_sigma] : {Motion{"easy_ski", 0.006}, {"ski", 0.015}}) {
    const int runs = seeds(3, 20);
    double nees = 0;
    for (int seed = 1; seed <= runs; ++seed) {
      Case c = make_case(motion, 40, static_cast<std::uint64_t>(seed));
      const Vector3d truth = c.options.gnss[0].lever_arm;
      c.options.gnss[0].lever_arm.setZero();
      const LeverArmGuess guess = lever_arm(c.simulation.recording(0), c.conditioning, c.options);
      const Vector3d error = guess.value - truth;
      nees += error.cwiseQuotient(guess.sigma).squaredNorm() / (3 * runs);
      fmt::print(
          "{}: lever arm {:.3f} {:.3f} {:.3f} ± {:.3f} {:.3f} {:.3f} m, off by {:.3f} {:.3f} {:.3f}; {} used, {} "
          "rejected\n",
          motion, guess.value.x(), guess.value.y(), guess.value.z(), guess.sigma.x(), guess.sigma.y(), guess.sigma.z(),
          error.x(), error.y(), error.z(), guess.used, guess.rejected);
      EXPECT_LT(guess.sigma.maxCoeff(), largest_sigma);
      EXPECT_LT(guess.rejected, guess.used / 20);
    }
    const Band band = chi_squared_band(0.999, 3, runs);
    fmt::print("{}: NEES {:.2f}, band {:.2f} to {:.2f}\n", motion, nees, band.low, band.high);
    EXPECT_TRUE(band.contains(nees)) << motion << ": " << nees;
  }
}

// An antenna that is not on the body.
TEST(LeverArm, OfFourMetresShows) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Case c = make_case("easy_ski", 40, seed, [](Scenario& s) { s.gnss[0].p_ra_r += Vector3d(4, 0, 0); });
    const Vector3d truth = c.options.gnss[0].lever_arm;
    c.options.gnss[0].lever_arm.setZero();
    const LeverArmGuess guess = lever_arm(c.simulation.recording(0), c.conditioning, c.options);
    fmt::print("off {:.2f} m, sigma {:.3f} m, value {:.2f} m, {} used {} rejected\n", (guess.value - truth).norm(),
               guess.sigma.maxCoeff(), guess.value.norm(), guess.used, guess.rejected);
    EXPECT_GT(guess.value.norm(), 1);
  }
}

}  // namespace
}  // namespace piste::test
