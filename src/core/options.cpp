#include "piste/core/options.h"

#include <fmt/format.h>

#include <algorithm>

#include "piste/core/error.h"
#include "piste/core/state_table.h"

namespace piste {

bool FilterOptions::estimates(Block block) const { return std::ranges::find(estimate, block) != estimate.end(); }

void FilterOptions::validate() const {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw ConfigError("", what);
  };
  behaviour.validate();
  std::vector<Block> states = estimate;
  for (const Block b : imu_error_blocks(sensor)) {
    if (!estimates(b)) states.push_back(b);
  }
  require(
      StateLayout(states).size() <= kMostStates,
      fmt::format("estimate: a run has {} states at most, with the errors that the sensor file states", kMostStates));
  require(sensor.gyro.noise > 0 && sensor.accel.noise > 0, "noise of the IMU must be above zero");
  require(!adapt || (adapt->within > 1 && adapt->time > 0 && adapt->imu_time > 0),
          "adapt: `within` must be above 1, `time` and `imu_time` above zero");
  require(!vehicle || (vehicle->interval > 0 && vehicle->slip.correlation_time > 0),
          "vehicle: the interval of its updates and the correlation time of its slip must be above zero");
  require(!magnetometer || magnetometer->sigma > 0, "magnetometer: its noise must be above zero");
  require(!odometer || vehicle, "odometer: it measures along a vehicle; add `vehicle: {kind: car}`");
  for (std::size_t i = 0; i < gnss.size(); ++i) {
    require(!gnss[i].drift || i < kDriftingReceivers,
            fmt::format("gnss drift: only the first {} receivers may have one", kDriftingReceivers));
    require(!gnss[i].lever_arm_sway || i < kDriftingReceivers,
            fmt::format("gnss lever_arm_sway: only the first {} receivers may have one", kDriftingReceivers));
    require(!gnss[i].drift || !gnss[i].drift->of_stated || gnss[i].drift->sigma.maxCoeff() < 1,
            "gnss drift: its share of the stated sigma must be below 1");
  }
  const auto giving =
      std::count_if(attitude.begin(), attitude.end(), [](const auto& a) { return a.boresight_drift.has_value(); });
  require(giving <= 1, "attitude boresight: one source at most may say how the boresight changes");
}

}  // namespace piste
