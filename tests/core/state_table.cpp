#include "piste/core/state_table.h"

#include <gtest/gtest.h>

#include <set>

namespace piste {
namespace {

TEST(BlockTable, NamesAreUniqueAndRowsComplete) {
  std::set<std::string_view> names;
  int size = 0;
  for (const BlockInfo& row : kBlocks) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(full_offset(row.block), size);
    EXPECT_TRUE(row.size == 1 || row.size % 3 == 0);
    EXPECT_LE(row.size, kLargestBlock);
    EXPECT_GT(row.factor, 0);
    for (int k = 0; k < row.size; ++k) EXPECT_FALSE(row.axes[static_cast<std::size_t>(k)].empty()) << row.name;
    size += row.size;
  }
  EXPECT_EQ(size, kFullSize);
}

TEST(StateLayout, NavigationAlwaysLeads) {
  const StateLayout layout;
  EXPECT_EQ(layout.size(), 9);
  EXPECT_EQ(layout.offset(Block::kPosition), 0);
  EXPECT_EQ(layout.offset(Block::kVelocity), 3);
  EXPECT_EQ(layout.offset(Block::kAttitude), 6);
  EXPECT_FALSE(layout.has(Block::kGyroBias));
  EXPECT_EQ(layout.offset(Block::kGyroBias), -1);
}

TEST(StateLayout, BlocksStandInTableOrderHoweverTheyAreNamed) {
  const std::vector<Block> named{Block::kAttitudeDrift, Block::kGnssDelay, Block::kVelocity, Block::kGyroBias};
  const StateLayout layout(named);
  EXPECT_EQ(layout.size(), 9 + 3 + 1 + 3);
  EXPECT_EQ(layout.offset(Block::kGyroBias), 9);
  EXPECT_EQ(layout.offset(Block::kGnssDelay), 12);
  EXPECT_EQ(layout.offset(Block::kAttitudeDrift), 13);
  EXPECT_EQ(layout.blocks().size(), 6U);
}

TEST(StateLayout, EveryBlockFits) {
  std::vector<Block> all;
  for (const BlockInfo& row : kBlocks) all.push_back(row.block);
  const StateLayout layout(all);
  EXPECT_EQ(layout.size(), kFullSize);
  for (const BlockInfo& row : kBlocks) EXPECT_EQ(layout.offset(row.block), full_offset(row.block));
}

}  // namespace
}  // namespace piste
