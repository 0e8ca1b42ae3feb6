#pragma once
/// A made-up run to draw: rest, two laps of a circle with hills, rest; one GNSS receiver and one attitude.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste::test {

struct SyntheticRun {
  Log log;
  Solution filtered, smoothed;
};

inline Estimate synthetic_estimate(double t, double wobble) {
  const double rest = 20, lap = 60, radius = 80;
  const double u = std::clamp((t - rest) / lap, 0.0, 2.0), turn = 2 * 3.14159265358979 * u;
  const bool moving = u > 0 && u < 2;
  const double speed = moving ? 2 * 3.14159265358979 * radius / lap : 0;
  Estimate x;
  x.p_wb = Vector3d(radius * std::sin(turn), radius * (1 - std::cos(turn)), -5 * std::sin(2 * turn));
  x.v_wb = speed * Vector3d(std::cos(turn), std::sin(turn), 0);
  x.q_wb = from_euler(Vector3d(moving ? 0.3 * std::sin(3 * turn) : 0, 0.05 * std::cos(turn), turn));
  x.gyro_bias = Vector3d(0.004, -0.002, 0.001) * (1 - wobble);
  x.accel_bias = Vector3d(0.05, -0.03, 0.02) * (1 - wobble);
  x.gyro_drift = 2e-4 * Vector3d(std::sin(t / 30), std::cos(t / 40), std::sin(t / 50));
  x.accel_drift = 0.01 * Vector3d(std::sin(t / 20), std::cos(t / 35), std::sin(t / 55));
  x.q_rb = from_euler(Vector3d(0.02, -0.01, 0.05) * (1 - wobble));
  return x;
}

inline Sigmas synthetic_sigmas(double t, double factor) {
  const double shrink = factor * (0.1 + std::exp(-t / 20));
  Sigmas s;
  s.position = shrink * Vector3d(0.3, 0.3, 0.6);
  s.velocity = shrink * Vector3d(0.05, 0.05, 0.08);
  s.euler = shrink * Vector3d(0.01, 0.01, 0.2);
  s.blocks.setConstant(shrink * 0.01);
  s.gyro_total_bias.setConstant(shrink * 0.002);
  s.accel_total_bias.setConstant(shrink * 0.02);
  return s;
}

/// `rate` epochs a second over 160 s.
inline SyntheticRun synthetic_run(double rate) {
  const std::array blocks{Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
                          Block::kAccelDrift, Block::kGyroScale, Block::kBoresight};
  SyntheticRun run;
  run.log.world = World({0.81, 0.12, 1600});
  run.filtered = Solution(StateLayout(blocks), run.log.world);
  run.smoothed = Solution(StateLayout(blocks), run.log.world);
  run.filtered.sources = {"gnss[0].position", "attitude[0]"};
  run.log.gnss.resize(1);
  run.log.rest = {{345000, 345020}, {345140, 345160}};
  run.log.counts.gnss_withheld = {7};
  run.log.counts.gnss_outside = {0};
  const int epochs = static_cast<int>(160 * rate);
  for (int i = 0; i <= epochs; ++i) {
    const double t = i / rate, time = 345000 + t;
    ImuSample sample;
    sample.time = time;
    run.log.imu.push_back(sample);
    run.filtered.append(time, synthetic_estimate(t, std::exp(-t / 15)), synthetic_sigmas(t, 1));
    run.smoothed.append(time, synthetic_estimate(t, 0), synthetic_sigmas(200, 1));
    if (i % static_cast<int>(rate / 4) != 0) continue;
    const Vector3d noise(std::sin(17 * t), std::sin(23 * t + 1), std::sin(31 * t + 2));
    const Vector3d sigma(0.5, 0.5, 0.8);
    run.log.gnss[0].push_back({time, run.filtered.estimate(run.filtered.size() - 1).p_wb + 0.5 * noise, sigma, {}});
    const bool wild = i % 97 == 0 && i > 0;
    const double nis = (wild ? 40 : 2) * noise.squaredNorm() + 0.01;
    run.filtered.innovations.push_back({time, 0, 3, (wild ? 5 : 1) * noise.cwiseProduct(sigma), sigma, nis, 16.27,
                                        nis > 16.27 ? Outcome::kRejected : Outcome::kUsed});
    run.filtered.innovations.push_back(
        {time, 1, 1, Vector3d(0.01 * noise.z(), 0, 0), Vector3d(0.01, 0, 0), noise.z() * noise.z() + 1e-4, 10.83, {}});
  }
  return run;
}

}  // namespace piste::test
