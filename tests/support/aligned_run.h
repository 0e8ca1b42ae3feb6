#pragma once
/// Two IMUs on one plate that stand, turn and stand again; all errors of one IMU are known.

#include <algorithm>
#include <cmath>

#include "piste/core/aligned.h"
#include "piste/core/log.h"
#include "support/random.h"

namespace piste::test {

struct AlignedRun {
  Vector3d gyro_bias{0.01, -0.004, 0.006}, accel_bias{0.05, -0.03, 0.08};
  Vector3d gyro_scale{0.02, -0.01, 0.005}, accel_scale{-0.02, 0.03, -0.01};
  double gyro_noise = 0.006, accel_noise = 0.03;  ///< standard deviation of a sample
  double persistence = 0;                         ///< correlation of the noise from one sample to the next: AR(1)
  double reference_noise = 0;                     ///< white noise of the reference, as a fraction of the above
  double delay = 0;                               ///< s by which the body IMU's samples come late
  double rest = 40, run = 60, start = 1000, rate = 100;

  Interval before() const { return {start, start + rest}; }
  Interval moving() const { return {start + rest, start + rest + run}; }
  Interval after() const { return {start + rest + run, start + 2 * rest + run}; }

  /// Rates and forces at a time after the start.
  void motion(double t, Vector3d& w, Vector3d& f) const {
    const double s = std::clamp(t - rest, 0.0, run);
    const double ease = std::min({1.0, s / 2, (run - s) / 2});  // sets off and stops within two seconds
    w = ease * Vector3d(0.9 * std::sin(1.9 * s), 0.25 + 0.3 * std::sin(3.1 * s), 0.5 * std::cos(1.3 * s));
    f = Vector3d(-2, 0.1, -9.6) +
        ease * Vector3d(1.5 * std::sin(2.3 * s), 2.5 * std::sin(1.9 * s + 1), 3 * std::cos(2.7 * s));
  }

  AlignedImus simulate(std::uint64_t seed) const {
    Random random(seed);
    AlignedImus out;
    out.interval = 1 / rate;
    Vector3d e_w = Vector3d::Zero(), e_f = Vector3d::Zero();
    const double drive = std::sqrt(1 - persistence * persistence);
    const auto n = static_cast<int>((2 * rest + run) * rate);
    for (int i = 1; i <= n; ++i) {
      const double t = i / rate;
      Vector3d w, f, w_late, f_late;
      motion(t, w, f);
      motion(t - delay, w_late, f_late);
      e_w = persistence * e_w + drive * random.vector(gyro_noise);
      e_f = persistence * e_f + drive * random.vector(accel_noise);
      out.time.push_back(start + t);
      out.gyro.emplace_back(w_late + gyro_scale.cwiseProduct(w_late) + gyro_bias + e_w);
      out.accel.emplace_back(f_late + accel_scale.cwiseProduct(f_late) + accel_bias + e_f);
      out.reference_gyro.emplace_back(w + reference_noise * random.vector(gyro_noise));
      out.reference_accel.emplace_back(f + reference_noise * random.vector(accel_noise));
      out.usable.push_back(1);
    }
    return out;
  }
};

}  // namespace piste::test
