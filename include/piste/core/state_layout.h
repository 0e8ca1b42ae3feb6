#pragma once
/// The one table of state blocks: it drives the error state, config keys, file columns, plots and tests.

#include <Eigen/Core>
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "piste/math/units.h"

namespace piste {

enum class Block {
  kPosition,
  kVelocity,
  kAttitude,
  kGyroBias,
  kAccelBias,
  kGyroDrift,
  kAccelDrift,
  kGyroScale,
  kAccelScale,
  kBoresight,
  kLeverArm,
  kGnssPositionDrift,
  kGnssDelay,
  kAttitudeDrift,
  kBoresightDrift,
};

/// One row of the table. `unit` is what files and plots show, `factor` turns SI and radians into it.
struct BlockInfo {
  Block block;
  std::string_view name;
  int size;
  std::string_view unit;
  double factor;
  std::array<std::string_view, 3> axes;
};

inline constexpr auto kBlocks = std::to_array<BlockInfo>({
    {Block::kPosition, "position", 3, "m", 1, {"north", "east", "down"}},
    {Block::kVelocity, "velocity", 3, "m/s", 1, {"north", "east", "down"}},
    {Block::kAttitude, "attitude", 3, "deg", kDegreesPerRadian, {"north", "east", "down"}},
    {Block::kGyroBias, "gyro_bias", 3, "deg/s", kDegreesPerRadian, {"x", "y", "z"}},
    {Block::kAccelBias, "accel_bias", 3, "m/s^2", 1, {"x", "y", "z"}},
    {Block::kGyroDrift, "gyro_drift", 3, "deg/s", kDegreesPerRadian, {"x", "y", "z"}},
    {Block::kAccelDrift, "accel_drift", 3, "m/s^2", 1, {"x", "y", "z"}},
    {Block::kGyroScale, "gyro_scale", 3, "ppm", 1e6, {"x", "y", "z"}},
    {Block::kAccelScale, "accel_scale", 3, "ppm", 1e6, {"x", "y", "z"}},
    {Block::kBoresight, "boresight", 3, "deg", kDegreesPerRadian, {"roll", "pitch", "heading"}},
    {Block::kLeverArm, "lever_arm", 3, "m", 1, {"x", "y", "z"}},
    {Block::kGnssPositionDrift, "gnss_position_drift", 3, "m", 1, {"north", "east", "down"}},
    {Block::kGnssDelay, "gnss_delay", 1, "s", 1, {"t", "", ""}},
    {Block::kAttitudeDrift, "attitude_drift", 3, "deg", kDegreesPerRadian, {"north", "east", "down"}},
    {Block::kBoresightDrift, "boresight_drift", 3, "deg", kDegreesPerRadian, {"x", "y", "z"}},
});

inline constexpr int kBlockCount = static_cast<int>(kBlocks.size());

constexpr int index_of(Block block) { return static_cast<int>(block); }
constexpr const BlockInfo& info(Block block) { return kBlocks[static_cast<std::size_t>(block)]; }

/// Place of a block in the error vector that holds every block.
constexpr int full_offset(Block block) {
  int offset = 0;
  for (int i = 0; i < index_of(block); ++i) offset += kBlocks[static_cast<std::size_t>(i)].size;
  return offset;
}

inline constexpr int kFullSize = full_offset(kBlocks.back().block) + kBlocks.back().size;

namespace detail {
constexpr bool table_matches_enum() {
  for (int i = 0; i < kBlockCount; ++i) {
    if (index_of(kBlocks[static_cast<std::size_t>(i)].block) != i) return false;
  }
  return true;
}
}  // namespace detail
static_assert(detail::table_matches_enum(), "kBlocks must list the blocks in the order of the enum");
static_assert(full_offset(Block::kAttitude) == 6, "position, velocity and attitude come first");

/// Error of every block, in table order, SI and radians.
using FullError = Eigen::Matrix<double, kFullSize, 1>;
/// Error of the estimated blocks, and its covariance: sized at run time, stored in place.
using ErrorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kFullSize, 1>;
using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kFullSize, kFullSize>;

/// Which blocks a run estimates, and where each stands. Position, velocity and attitude always lead.
class StateLayout {
 public:
  StateLayout() : StateLayout(std::span<const Block>{}) {}
  /// `extra` in any order, without repetition; the navigation blocks may be named or not.
  explicit StateLayout(std::span<const Block> extra);

  int size() const { return size_; }
  bool has(Block block) const { return offset_[static_cast<std::size_t>(block)] >= 0; }
  /// First row of the block, −1 where it is not estimated.
  int offset(Block block) const { return offset_[static_cast<std::size_t>(block)]; }
  const std::vector<Block>& blocks() const { return blocks_; }

 private:
  std::array<int, kBlocks.size()> offset_;
  std::vector<Block> blocks_;
  int size_ = 0;
};

}  // namespace piste
