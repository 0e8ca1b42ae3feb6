#include "quantity.h"

namespace piste {

std::vector<Quantity> quantities_of(const StateLayout& layout) {
  std::vector<Quantity> result;
  for (const Block block : layout.blocks()) {
    if (!is_navigation(block)) result.push_back({std::string(info(block).name), block, false});
  }
  if (layout.has(Block::kGyroBias) || layout.has(Block::kGyroDrift)) {
    result.push_back({"gyro_total_bias", Block::kGyroBias, true});
  }
  if (layout.has(Block::kAccelBias) || layout.has(Block::kAccelDrift)) {
    result.push_back({"accel_total_bias", Block::kAccelBias, true});
  }
  return result;
}

std::pair<BlockValues, BlockValues> shown(const Quantity& q, const Estimate& x, const Sigmas& s) {
  const double factor = info(q.block).factor;
  if (q.total) {
    const bool gyro = q.block == Block::kGyroBias;
    BlockValues value = BlockValues::Zero(), sigma = value;
    value.head<3>() = factor * (gyro ? x.gyro_bias + x.gyro_drift : x.accel_bias + x.accel_drift);
    sigma.head<3>() = factor * (gyro ? s.gyro_total_bias : s.accel_total_bias);
    return {value, sigma};
  }
  BlockValues sigma = BlockValues::Zero();
  sigma.head(q.size()) = s.blocks.segment(full_offset(q.block), q.size());
  return {factor * shown_value(x, q.block), factor * sigma};
}

}  // namespace piste
