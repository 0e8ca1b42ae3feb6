#pragma once
/// A scenario file, `config/scenarios/*.yaml`: a motion, the sensors that are carried, and how a Monte Carlo replays
/// them.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "piste/sim/motion.h"
#include "piste/sim/replay_setup.h"
#include "piste/sim/sensors.h"

namespace piste {

class Config;

/// The plate r that all sensors are fixed to sits at the trunk's point, turned by `q_tr`.
struct Scenario {
  std::string file, text;  ///< where it came from, and as it stands there
  Geodetic origin;
  double start_time = 0;  ///< GPS seconds of week
  std::uint64_t seed = 1;
  MotionOptions motion;
  Quaterniond q_tr = Quaterniond::Identity();
  std::vector<ImuSetup> imus;  ///< the first one is the body of truth.csv
  std::vector<GnssSetup> gnss;
  std::vector<AttitudeSetup> attitude;
  std::size_t truth_every = 1;  ///< truth.csv has every n-th IMU epoch
  ReplaySetup replay;           ///< of a Monte Carlo
};

/// Reads a scenario. Every error is a ConfigError `FILE:LINE: …`.
Scenario read_scenario(const std::filesystem::path& file);

/// The motion of a scenario's section `motion:`; what it does not say stays that of `fallback`.
MotionOptions read_motion(const Config& section, MotionOptions fallback);

}  // namespace piste
