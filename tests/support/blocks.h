#pragma once
/// As many blocks as one run may have.

#include <vector>

#include "piste/core/state_table.h"

namespace piste::test {

/// All blocks of the table but the last: a run has at most kMostStates states.
inline std::vector<Block> most_blocks() {
  std::vector<Block> blocks;
  for (const BlockInfo& row : kBlocks) blocks.push_back(row.block);
  blocks.pop_back();
  return blocks;
}

}  // namespace piste::test
