#pragma once
/// Two simulated IMUs on one plate, with all parameters between them that an alignment estimates.

#include <cmath>
#include <string>

#include "piste/condition/pipeline.h"
#include "piste/condition/time_sync.h"
#include "piste/sim/random.h"
#include "piste/sim/scenario.h"
#include "piste/sim/simulation.h"
#include "support/places.h"
#include "support/scenario.h"

namespace piste::test {

struct ImuPair {
  ImuSetup setup;  ///< of the body IMU: the true values
  ImuSensor reference_sensor;
  std::vector<ImuSample> body, reference;
  SimulatedImu simulated;  ///< the body IMU
  Interval under_way;
};

/// An MT-9A and an LN200 in a scenario of config/scenarios: offset within ±20 s, drift of some 30 ppm, boresight of
/// some degrees, 7 cm apart, all drawn by the seed.
inline Scenario pair_scenario(const std::string& name, std::uint64_t seed, double rest, double run) {
  Scenario s = read_scenario(source_folder() + "/config/scenarios/" + name + ".yaml");
  shorten(s, rest, run, rest);
  RandomStream draw(seed, "pair");
  ImuSetup body = s.imus.front(), reference = s.imus.back();
  body.clock_offset = 20 * (2 * draw.uniform() - 1);
  body.clock_drift = 30e-6 * draw.normal();
  body.q_rb = so3_exp(0.05 * draw.normal3());
  body.p_rb_r = 0.07 * draw.normal3().normalized();
  s.imus = {body, reference};
  s.gnss.clear();
  s.attitude.clear();
  return s;
}

inline ConditioningOptions conditioning_of(const ImuSetup& setup) {
  ConditioningOptions options;
  options.gyro_range = setup.sensor.gyro.range;
  options.accel_range = setup.sensor.accel.range;
  options.imu.instantaneous = setup.sampling == ImuSetup::Sampling::kInstant;
  return options;
}

inline ImuPair simulate_pair(const Scenario& s, std::uint64_t seed) {
  Simulation simulation = simulate(s, seed);
  ImuPair pair;
  pair.setup = s.imus.front();
  pair.reference_sensor = s.imus.back().sensor;
  pair.body = condition_imu(simulation.imus.front().recording, conditioning_of(s.imus.front())).imu;
  pair.reference = condition_imu(simulation.imus.back().recording, conditioning_of(s.imus.back())).imu;
  pair.simulated = std::move(simulation.imus.front());
  pair.under_way = simulation.plate.under_way();
  return pair;
}

/// truth = estimate ⊞ error of offset, drift, boresight and lever arm, the first parameters of an alignment.
inline Eigen::Matrix<double, 8, 1> alignment_error(const Alignment& a, const ImuSetup& truth) {
  Eigen::Matrix<double, 8, 1> e;
  e << truth.clock_offset - a.clock_offset, truth.clock_drift - a.clock_drift, so3_log(truth.q_rb * a.q_rb.conjugate()),
      truth.p_rb_r - a.p_rb_r;
  return e;
}

}  // namespace piste::test
