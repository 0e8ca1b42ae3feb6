#include "piste/core/options.h"

#include <fmt/format.h>

#include <algorithm>

#include "piste/core/error.h"

namespace piste {

void FilterOptions::validate() const {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw ConfigError("", what);
  };
  require(gate > 0 && gate < 1, fmt::format("gate {}: a probability between 0 and 1, such as 0.999", gate));
  require(sensor.gyro.noise > 0 && sensor.accel.noise > 0, "noise of the IMU must be above zero");
  const auto drifting = std::count_if(gnss.begin(), gnss.end(), [](const auto& g) { return g.drift.has_value(); });
  require(drifting <= 1, "gnss drift: one receiver at most may have a coloured error");
  const auto giving =
      std::count_if(attitude.begin(), attitude.end(), [](const auto& a) { return a.boresight_drift.has_value(); });
  require(giving <= 1, "attitude boresight: one source at most may say how the boresight changes");
  require(rest.sigma_velocity > 0 && rest.sigma_rate > 0 && rest.interval > 0 && rest.correlation_time >= 0,
          "rest: sigmas and interval must be above zero, and correlation_time not below");
}

bool has_error(const ImuSensor& sensor, Block block) {
  constexpr auto kNone = DriftProcess::Kind::kNone;
  switch (block) {
    case Block::kGyroBias:
      return sensor.gyro.bias > 0;
    case Block::kAccelBias:
      return sensor.accel.bias > 0;
    case Block::kGyroScale:
      return sensor.gyro.scale > 0;
    case Block::kAccelScale:
      return sensor.accel.scale > 0;
    case Block::kGyroDrift:
      return sensor.gyro.drift.kind != kNone;
    case Block::kAccelDrift:
      return sensor.accel.drift.kind != kNone;
    case Block::kPosition:
    case Block::kVelocity:
    case Block::kAttitude:
    case Block::kBoresight:
    case Block::kLeverArm:
    case Block::kGnssPositionDrift:
    case Block::kGnssDelay:
    case Block::kAttitudeDrift:
    case Block::kBoresightDrift:
      return true;
  }
  return true;
}

std::vector<Block> imu_error_blocks(const ImuSensor& sensor) {
  std::vector<Block> out;
  for (const Block block : {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift,
                            Block::kGyroScale, Block::kAccelScale}) {
    if (has_error(sensor, block)) out.push_back(block);
  }
  return out;
}

}  // namespace piste
