#pragma once
/// As many blocks as one run may have.

#include <vector>

#include "piste/core/state_table.h"

namespace piste::test {

/// All blocks of the table but the last ones: a run has at most kMostStates states.
inline std::vector<Block> most_blocks() {
  std::vector<Block> blocks;
  for (const BlockInfo& row : kBlocks) {
    if (full_offset(row.block) + row.size <= kMostStates) blocks.push_back(row.block);
  }
  return blocks;
}

}  // namespace piste::test
