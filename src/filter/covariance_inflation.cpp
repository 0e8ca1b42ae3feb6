#include "filter/covariance_inflation.h"

#include <algorithm>
#include <optional>

namespace piste {
namespace {

// The drift of the mean of several IMUs, if `block` is that of one of their parities.
std::optional<Block> mean_of(Block block) {
  for (const Block drift : {Block::kGyroDrift, Block::kAccelDrift}) {
    for (int parity = 0; parity < kMostParities; ++parity) {
      if (block == parity_block(drift, parity)) return drift;
    }
  }
  return std::nullopt;
}

}  // namespace

void inflate_covariance(Covariance& P, const StateLayout& layout, const Linearization& lin, double lapse,
                        const FaultDetectionOptions& options) {
  const double size = lin.residual.head(lin.rows).norm();
  double position = 0, velocity = 0, attitude = 0;
  switch (lin.observes) {
    case Block::kPosition:
      position = size;
      velocity = size / lapse;
      attitude = 2 * size / (kStandardGravity * lapse * lapse);
      break;
    case Block::kVelocity:
      velocity = size;
      attitude = size / (kStandardGravity * lapse);
      break;
    case Block::kAttitude:
      attitude = size;
      break;
    default:
      break;
  }
  attitude = std::min(attitude, options.largest_tilt);
  const auto add = [&](Block b, double sigma) { P.diagonal().segment<3>(layout.offset(b)).array() += sigma * sigma; };
  add(Block::kPosition, position);
  add(Block::kVelocity, velocity);
  add(Block::kAttitude, attitude);
  // The difference between several IMUs has changed, because one of them has. The parity does not identify this IMU, so
  // that the mean may be wrong by as much.
  if (const std::optional<Block> mean = mean_of(lin.observes)) {
    for (const Block drift : {lin.observes, *mean}) {
      if (layout.has(drift)) P.diagonal().segment<3>(layout.offset(drift)) += lin.residual.cwiseAbs2();
    }
  }
}

}  // namespace piste
