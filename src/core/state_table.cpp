#include "piste/core/state_table.h"

namespace piste {

StateLayout::StateLayout(std::span<const Block> extra) {
  offset_.fill(-1);
  for (const BlockInfo& row : kBlocks) {
    if (!is_navigation(row.block) && std::find(extra.begin(), extra.end(), row.block) == extra.end()) continue;
    offset_[static_cast<std::size_t>(row.block)] = size_;
    blocks_.push_back(row.block);
    size_ += row.size;
  }
}

bool has_error(const FilterOptions& options, Block block) {
  const BlockInfo& row = info(block);
  if (row.process) return row.process(options).has_value();
  return !row.prior || !row.prior(options).isZero(0);
}

std::vector<Block> imu_error_blocks(const ImuSensor& sensor) {
  FilterOptions options;
  options.sensor = sensor;
  std::vector<Block> out;
  for (const Block block :
       {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift, Block::kGyroScale,
        Block::kAccelScale, Block::kGyroCrossAxis, Block::kAccelCrossAxis, Block::kGyroGSensitivity}) {
    if (has_error(options, block)) out.push_back(block);
  }
  return out;
}

std::vector<Block> position_drifts(const FilterOptions& options) {
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < options.gnss.size(); ++i) {
    const auto& drift = options.gnss[i].drift;
    if (drift) blocks.push_back(position_drift_block(static_cast<int>(i), drift->of_stated));
  }
  return blocks;
}

std::vector<Block> with_implied_blocks(const FilterOptions& options, std::vector<Block> wanted) {
  for (const BlockInfo& row : kBlocks) {
    const bool there = row.observed ? row.observed(options) : has_error(options, row.block);
    if (!row.implied || !there) continue;
    if (std::find(wanted.begin(), wanted.end(), row.block) == wanted.end()) wanted.push_back(row.block);
  }
  return wanted;
}

}  // namespace piste
