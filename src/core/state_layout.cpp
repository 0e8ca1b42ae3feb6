#include "piste/core/state_layout.h"

#include <algorithm>

namespace piste {

StateLayout::StateLayout(std::span<const Block> extra) {
  offset_.fill(-1);
  for (const BlockInfo& row : kBlocks) {
    const bool navigation = index_of(row.block) <= index_of(Block::kAttitude);
    if (!navigation && std::find(extra.begin(), extra.end(), row.block) == extra.end()) continue;
    offset_[static_cast<std::size_t>(row.block)] = size_;
    blocks_.push_back(row.block);
    size_ += row.size;
  }
}

}  // namespace piste
