#include "model/vector_pairs.h"

#include <gtest/gtest.h>

#include "support/motion.h"
#include "support/random.h"

namespace piste::test {
namespace {

// A rotation, and pairs that it turns into one another exactly.
std::vector<VectorPair> exact_pairs(const Quaterniond& q, Random& random) {
  std::vector<VectorPair> pairs;
  for (int i = 0; i < 12; ++i) {
    const Vector3d alpha = random.vector(1);
    pairs.push_back({0.3 * i + 0.1 * random.uniform(), alpha, q * alpha, 0.5 + random.uniform()});
  }
  return pairs;
}

TEST(ProjectedOut, ConstantsAndLinesLeaveNoTrace) {
  Random random(1);
  const Quaterniond q = random.rotation();
  for (const bool lines : {false, true}) {
    const std::vector<VectorPair> pairs = exact_pairs(q, random);
    std::vector<VectorPair> moved = pairs;
    const Vector3d v0 = random.vector(10), p0 = random.vector(1000);
    for (VectorPair& p : moved) p.beta += p0 + (lines ? p.time : 0) * v0;
    const auto expected = projected_out(pairs, lines), found = projected_out(moved, lines);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      EXPECT_LT((found[i].beta - expected[i].beta).norm(), 1e-10);
      // What is left still is one rotation of the other.
      EXPECT_LT((found[i].beta - q * found[i].alpha).norm(), 1e-10);
    }
  }
}

TEST(ProjectedOut, IsAProjection) {
  Random random(2);
  for (const bool lines : {false, true}) {
    const auto once = projected_out(exact_pairs(random.rotation(), random), lines), twice = projected_out(once, lines);
    for (std::size_t i = 0; i < once.size(); ++i) EXPECT_LT((once[i].alpha - twice[i].alpha).norm(), 1e-13);
  }
}

TEST(PairsOf, DifferByTheStartOfTheMotionAlone) {
  const WildMotion motion;
  GnssOptions receiver;
  receiver.lever_arm = Vector3d(-0.1, 0.05, -0.4);
  const Vector3d gravity = motion.gravity().value;
  std::vector<GnssFix> fixes;
  for (int i = 0; i < 8; ++i) fixes.push_back(motion.fix(2 + 0.25 * i + 0.003, receiver.lever_arm));
  const auto pairs = pairs_of(motion.samples(1.9, 4, 0.005), fixes, receiver, {}, gravity);
  ASSERT_TRUE(pairs);
  ASSERT_EQ(pairs->velocity.size(), fixes.size());
  ASSERT_EQ(pairs->position.size(), fixes.size());
  const auto start = motion.at(fixes.front().time);
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const VectorPair &v = pairs->velocity[i], &p = pairs->position[i];
    EXPECT_LT((v.beta - (start.v_wb + start.q_wb * v.alpha)).norm(), 0.02) << i;
    EXPECT_LT((p.beta - (start.p_wb + v.time * start.v_wb + start.q_wb * p.alpha)).norm(), 0.02) << i;
  }
}

}  // namespace
}  // namespace piste::test
