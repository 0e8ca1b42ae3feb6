// The two parts of a batch's unknowns: what is stored is what is loaded, and errors are the whole run's.

#include "batch/layout.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/blocks.h"
#include "support/random.h"

namespace piste::test {
namespace {

TEST(BatchLayout, PartsShareTheWholeBetweenThem) {
  const BatchLayout layout{StateLayout(most_blocks())};
  EXPECT_EQ(layout.node.size() + layout.constant.size(), layout.whole.size());
  EXPECT_GE(layout.node.offset(Block::kAttitude), 0);
  EXPECT_EQ(layout.constant.offset(Block::kAttitude), -1);
  EXPECT_GE(layout.constant.offset(Block::kBoresight), 0) << "a constant";
  EXPECT_EQ(layout.node.offset(Block::kBoresight), -1);
  // A rotation is stored as a quaternion, which has a value more than its error.
  EXPECT_EQ(layout.node.stored(), layout.node.size() + 1);
  EXPECT_GT(layout.constant.stored(), layout.constant.size());

  ErrorVector error = ErrorVector::Zero(layout.whole.size());
  Eigen::VectorXd counted = Eigen::VectorXd::LinSpaced(layout.whole.size(), 1, layout.whole.size());
  layout.node.put(counted.data(), error);
  layout.constant.put(counted.data() + layout.node.size(), error);
  EXPECT_EQ(error.sum(), counted.sum()) << "every row once";
  for (const BatchLayout::Part* part : {&layout.node, &layout.constant}) {
    for (const Block b : part->blocks)
      EXPECT_EQ(part->rows[static_cast<std::size_t>(part->offset(b))], layout.whole.offset(b));
  }
}

TEST(BatchLayout, WhatIsStoredIsLoaded) {
  const BatchLayout layout{StateLayout(most_blocks())};
  Random random(3);
  const Estimate x = random.estimate(), other = random.estimate();
  for (const BatchLayout::Part* part : {&layout.node, &layout.constant}) {
    std::vector<double> values(static_cast<std::size_t>(part->stored()));
    part->store(x, values.data());
    Estimate loaded = other, copied = other;
    part->load(values.data(), loaded);
    part->copy(x, copied);
    EXPECT_TRUE(part->select(boxminus(loaded, x)).isZero(1e-14));
    EXPECT_TRUE(boxminus(copied, loaded).isZero(1e-14));
    EXPECT_FALSE(part->select(boxminus(other, x)).isZero(0.1));
    const BatchLayout::Part& rest = part == &layout.node ? layout.constant : layout.node;
    EXPECT_TRUE(rest.select(boxminus(loaded, other)).isZero(1e-14)) << "the other part stays";
  }
}

TEST(BatchLayout, ErrorsOfAPartAreThoseOfTheWhole) {
  const BatchLayout layout{StateLayout(most_blocks())};
  Random random(4);
  const Estimate x = random.estimate();
  for (const BatchLayout::Part* part : {&layout.node, &layout.constant}) {
    const Eigen::VectorXd error = 0.01 * random.matrix(part->size(), 1);
    const FullError full = part->expand(error.data());
    EXPECT_TRUE(part->select(full) == error);
    EXPECT_NEAR(full.norm(), error.norm(), 1e-15) << "zero for the others";
    EXPECT_TRUE(part->select(boxminus(boxplus(x, full), x)).isApprox(error, 1e-9));
  }
  Eigen::VectorXd error = 0.01 * random.matrix(layout.constant.size(), 1), found(layout.constant.size());
  layout.constant.difference(boxplus(x, layout.constant.expand(error.data())), x, found.data());
  EXPECT_TRUE(found.isApprox(error, 1e-9));
}

}  // namespace
}  // namespace piste::test
