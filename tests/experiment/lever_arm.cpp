#include "experiment/lever_arm.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/simulated_case.h"

namespace piste::test {
namespace {

// What the motion tells of where the antenna sits, from nothing.
TEST(LeverArm, IsFoundFromTheMotion) {
  for (const char* motion : {"easy_ski", "ski"}) {
    Case c = make_case(motion, 40, 2);
    const Vector3d truth = c.options.gnss[0].lever_arm;
    c.options.gnss[0].lever_arm.setZero();
    const LeverArmGuess guess = lever_arm(c.simulation.recording(0), c.conditioning, c.options);
    const Vector3d error = guess.value - truth;
    fmt::print(
        "{}: lever arm {:.3f} {:.3f} {:.3f} ± {:.3f} {:.3f} {:.3f} m, off by {:.3f} {:.3f} {:.3f}; {} used, {} "
        "rejected\n",
        motion, guess.value.x(), guess.value.y(), guess.value.z(), guess.sigma.x(), guess.sigma.y(), guess.sigma.z(),
        error.x(), error.y(), error.z(), guess.used, guess.rejected);
    EXPECT_LT(error.norm(), 0.3);
    EXPECT_LT(guess.sigma.maxCoeff(), 0.2);
    EXPECT_LT(guess.rejected, guess.used / 20);
  }
}

// An antenna that is not on the body.
TEST(LeverArm, OfFourMetresShows) {
  Case c = make_case("easy_ski", 40, 2, [](Scenario& s) { s.gnss[0].p_ra_r += Vector3d(4, 0, 0); });
  const Vector3d truth = c.options.gnss[0].lever_arm;
  c.options.gnss[0].lever_arm.setZero();
  const LeverArmGuess guess = lever_arm(c.simulation.recording(0), c.conditioning, c.options);
  EXPECT_LT((guess.value - truth).norm(), 0.5) << guess.value.transpose();
  EXPECT_GT(guess.value.norm(), 3);
}

}  // namespace
}  // namespace piste::test
