#pragma once
/// Scenario files, such as those in `config/scenarios`: a motion, the sensors that are carried, and how `montecarlo`
/// replays them.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "piste/sim/aids.h"
#include "piste/sim/motion.h"
#include "piste/sim/replay_setup.h"
#include "piste/sim/sensors.h"

namespace piste {

class Config;

/// A scenario. All sensors are fixed to one plate r, which is at the origin of the trunk t and turned against it by
/// `q_tr`.
struct Scenario {
  std::string file, text;  ///< its file, and the text of that file
  Geodetic origin;
  double start_time = 0;  ///< GPS seconds of week
  std::uint64_t seed = 1;
  MotionOptions motion;
  Quaterniond q_tr = Quaterniond::Identity();
  std::vector<ImuSetup> imus;  ///< the first one is the body of truth.csv
  std::vector<GnssSetup> gnss;
  std::vector<AttitudeSetup> attitude;
  AidSetups aids;
  std::size_t truth_every = 1;  ///< truth.csv has every n-th IMU epoch
  ReplaySetup replay;           ///< of a Monte Carlo
};

/// Reads a scenario. Every error is a ConfigError `FILE:LINE: …`.
Scenario read_scenario(const std::filesystem::path& file);
Scenario read_scenario(const Config& config);

/// Reads the section `motion:` of a scenario. Keys that are missing have the values of `fallback`. Throws ConfigError.
MotionOptions read_motion(const Config& section, MotionOptions fallback);

}  // namespace piste
