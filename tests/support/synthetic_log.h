#pragma once
/// A short log of a wild motion with every sensor, and options and a start for its filter.

#include "piste/filter/filter.h"
#include "support/motion.h"
#include "support/random.h"

namespace piste::test {

struct SyntheticRun {
  Log log;
  FilterOptions options;
  Start start;
};

/// All blocks except those of several IMUs: this log has one IMU.
inline std::vector<Block> all_blocks() {
  std::vector<Block> blocks;
  for (const BlockInfo& row : kWrittenBlocks) blocks.push_back(row.block);
  return blocks;
}

/// Two seconds of standstill, then motion. Fixes are between the IMU samples, and every tenth one is on a sample.
inline SyntheticRun synthetic_run(double duration, const std::vector<Block>& estimate, std::uint64_t seed = 1) {
  Random random(seed);
  WildMotion motion;
  const double start = 100000, dt = 0.01, rest = std::min(2.0, 0.4 * duration);
  motion.begin = start + rest;
  const Vector3d lever_arm(-0.1, 0.05, -0.4);
  SyntheticRun run;
  const Vector3d kField(20, 0, 40);
  Log& log = run.log;
  log.world = motion.world;

  FilterOptions& o = run.options;
  o.sensor.gyro = {1e-3, 0.01, {DriftProcess::Kind::kGaussMarkov, 2e-4, 20, 0}, 0.01, 0};
  o.sensor.accel = {3e-3, 0.05, {DriftProcess::Kind::kRandomWalk, 0, 0, 1e-3}, 0.02, 0};
  o.gnss = {{"", lever_arm, true, true, GaussMarkov{{0.01, 0.01, 0.015}, 60}}, {"", lever_arm, true, true, {}}};
  o.attitude = {{"", GaussMarkov{{1e-3, 1e-3, 3e-3}, 30}, GaussMarkov{{1e-3, 1e-3, 1e-3}, 40}}};
  o.estimate = estimate;
  o.behaviour.rest.sigma_velocity = 0.01;
  o.behaviour.trust.gate = 0.999999;
  o.magnetometer = MagnetometerOptions{.sigma = 0.5};

  const Vector3d gyro_bias = random.vector(0.002), accel_bias = random.vector(0.02);
  for (ImuSample s : motion.samples(start, start + duration, dt)) {
    s.dtheta += dt * gyro_bias + random.vector(o.sensor.gyro.noise * std::sqrt(dt));
    s.dvel += dt * accel_bias + random.vector(o.sensor.accel.noise * std::sqrt(dt));
    log.imu.push_back(s);
  }
  const auto noisy = [&](GnssFix fix) {
    fix.position += random.vector(1).cwiseProduct(fix.sigma_position);
    fix.velocity->value += random.vector(1).cwiseProduct(fix.velocity->sigma);
    return fix;
  };
  log.gnss.resize(2);
  log.attitude.resize(1);
  for (int i = 0; i * 0.1 < duration - 0.01; ++i) {
    const double t = start + i * 0.1 + (i % 10 == 0 ? 0 : 0.0037);
    log.gnss[0].push_back(noisy(motion.fix(t, lever_arm)));
    if (i % 2 == 0) log.gnss[1].push_back(noisy(motion.fix(t, lever_arm, {0.3, 0.3, 0.5})));
    if (i % 3 == 0) {
      const auto x = motion.at(t);
      log.attitude[0].push_back({t, so3_exp(random.vector(1e-3)) * x.q_wb, 1e-6 * Matrix3d::Identity()});
      log.magnetic.push_back({t, x.q_wb.conjugate() * kField + random.vector(0.5), kField});
    }
  }
  if (rest > 0) log.rest.push_back({start, start + rest});

  const auto truth = motion.at(start);
  run.start.time = start;
  run.start.x.q_wb = so3_exp(random.vector(0.01)) * truth.q_wb;
  run.start.x.p_wb = truth.p_wb + random.vector(0.3);
  run.start.x.v_wb = truth.v_wb;
  run.start.x.lever_arm = lever_arm;
  run.start.covariance = Eigen::Matrix<double, 9, 9>::Zero();
  run.start.covariance.diagonal() << Vector3d::Constant(0.1), Vector3d::Constant(0.01), Vector3d(4e-4, 4e-4, 2e-3);
  return run;
}

}  // namespace piste::test
