#pragma once
/// A short simulated run, in the form that a replay takes.

#include <filesystem>
#include <functional>
#include <string>

#include "piste/condition/pipeline.h"
#include "piste/condition/rest_detection.h"
#include "piste/math/units.h"
#include "piste/sim/simulation.h"
#include "piste/start/start.h"
#include "support/places.h"

namespace piste::test {

/// A simulated run of one MT-9A and one receiver, and the configuration of its replay.
struct Case {
  Scenario scenario;
  Simulation simulation;
  FilterOptions options;
  ConditioningOptions conditioning;

  double under_way() const { return simulation.plate.under_way().start; }
  Log log() const { return condition(simulation.recording(0), conditioning); }
  FoundStart find(const InitialHeading& heading = {}) const { return find_start(log(), options, heading); }
};

inline Case make_case(const std::string& motion, double heading_deg, std::uint64_t seed,
                      const std::function<void(Scenario&)>& change = {}) {
  Scenario s = read_scenario(kSource / "config" / "scenarios" / (motion + ".yaml"));
  s.imus.resize(1);
  s.gnss.resize(1);
  s.attitude.clear();
  s.motion.heading = heading_deg * kDegree;
  s.motion.rest_before = 20;
  s.motion.run = 60;
  s.motion.rest_after = 3;
  if (change) change(s);
  Case c{s, simulate(s, seed), {}, {}};
  c.options.sensor = s.imus[0].sensor;
  c.options.gnss = {{.name = s.gnss[0].name, .lever_arm = lever_arm(s.imus[0], s.gnss[0]), .drift = {}}};
  if (!s.attitude.empty()) c.options.attitude = {{.name = s.attitude[0].name, .drift = {}}};
  c.options.estimate = {Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
                        Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};
  c.conditioning.imu.clock_offset = s.imus[0].clock_offset;
  c.conditioning.imu.clock_drift = s.imus[0].clock_drift;
  c.conditioning.magnetic.field = s.imus[0].magnetic_field;
  c.conditioning.gyro_range = c.options.sensor.gyro.range;
  c.conditioning.accel_range = c.options.sensor.accel.range;
  return c;
}

}  // namespace piste::test
