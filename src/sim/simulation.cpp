#include "piste/sim/simulation.h"

namespace piste {

Recording Simulation::recording(std::size_t imu) const {
  return {imus[imu].recording, gnss, attitude, aids.speed, aids.height, aids.heading};
}

Simulation simulate(const Scenario& scenario, std::uint64_t seed, const SimulationProgress& progress) {
  const World world(scenario.origin);
  const Truth trunk(world, scenario.motion, seed, scenario.start_time);
  Simulation run{trunk, trunk.attached(scenario.q_tr, Vector3d::Zero()), {}, {}, {}, {}};
  const std::size_t total = scenario.imus.size() + scenario.gnss.size() + scenario.attitude.size();
  const auto report = [&] {
    if (progress) progress(run.imus.size() + run.gnss.size() + run.attitude.size(), total);
  };
  for (const ImuSetup& imu : scenario.imus) {
    run.bodies.push_back(run.plate.attached(imu.q_rb, imu.p_rb_r));
    run.imus.push_back(simulate_imu(run.plate, imu, seed));
    report();
  }
  for (const GnssSetup& gnss : scenario.gnss) {
    run.gnss.push_back(simulate_gnss(run.plate, gnss, seed));
    report();
  }
  for (const AttitudeSetup& attitude : scenario.attitude) {
    run.attitude.push_back(simulate_attitude(run.plate, attitude, seed));
    report();
  }
  run.aids = simulate_aids(run.trunk, run.plate, scenario.aids, seed);
  return run;
}

Vector3d lever_arm(const ImuSetup& imu, const GnssSetup& gnss) {
  return imu.q_rb.conjugate() * (gnss.p_ra_r - imu.p_rb_r);
}

Vector3d bias_scale_correlation(const TriadDraw& draw) {
  return draw.run.mean.cwiseAbs().cwiseQuotient(draw.run.rms.cwiseMax(1e-300));
}

}  // namespace piste
