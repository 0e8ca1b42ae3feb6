#pragma once
/// How `montecarlo` replays a scenario: which sensors, what is estimated, and what the filter is told.

#include <cstddef>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/sensor.h"
#include "piste/core/state_layout.h"

namespace piste {

struct ReplaySetup {
  std::size_t imu = 0;
  std::vector<std::size_t> gnss, attitude;
  ImuSensor sensor;
  std::vector<Block> estimate;
  bool find_heading = false;
  bool random_heading = false;
  struct StartSigma {
    double position = 0.5, velocity = 0.05, tilt = 0.0058178, heading = 0.0174533;
  } start;
  std::vector<Interval> outages;
  double every = 1;
};

}  // namespace piste
