#pragma once
/// A made-up alignment, for pages.

#include <cmath>

#include "piste/report/alignment_figures.h"
#include "support/aligned_run.h"

namespace piste::test {

/// A picture and all objects to which it refers.
struct PictureOfRun {
  AlignedImus aligned;
  Alignment alignment;
  std::vector<ImuSample> body, reference;

  /// The body IMU's clock is `offset` ahead and gains 20 ppm; its axes are those of the reference.
  explicit PictureOfRun(const AlignedRun& run = {.rest = 10, .run = 30}, double offset = 2.5) {
    aligned = run.simulate(1);
    const double first = aligned.time.front() + offset;
    alignment.clock_offset = offset;
    alignment.clock_drift = 20e-6;
    alignment.q_rb = from_euler({0.02, -0.03, 0.05});
    alignment.p_rb_r = {0.07, 0, -0.01};
    alignment.gyro_bias = run.gyro_bias;
    alignment.accel_bias = run.accel_bias;
    alignment.gyro_scale = run.gyro_scale;
    alignment.accel_scale = run.accel_scale;
    alignment.covariance.setIdentity();
    alignment.covariance *= 1e-8;
    for (std::size_t i = 0; i < aligned.time.size(); ++i) {
      const double dt = aligned.interval, t = aligned.time[i];
      ImuSample s{
          .time = t, .interval = dt, .dtheta = dt * aligned.reference_gyro[i], .dvel = dt * aligned.reference_accel[i]};
      reference.push_back(s);
      s.time = (t + offset - 20e-6 * first) / (1 - 20e-6);
      s.dtheta = dt * aligned.gyro[i];
      s.dvel = dt * aligned.accel[i];
      body.push_back(s);
    }
    CorrelationPeak& peak = alignment.correlation;
    for (int i = -3000; i <= 3000; ++i) {
      peak.offset.push_back(0.01 * i);
      peak.correlation.push_back(std::exp(-std::abs(0.01 * i - offset)));
    }
    peak.peak_offset = offset;
    peak.peak = 0.99;
    peak.rival = 0.4;
    for (int i = 0; i < 5; ++i)
      alignment.local.push_back({aligned.time.front() + 5 + 10 * i, 1e-5 * (i % 3 - 1), 2e-5});
  }

  AlignmentPicture picture() const {
    ImuSensor sensor;
    sensor.gyro.noise = 6e-4;
    sensor.accel.noise = 3e-3;
    return {"plate & <ski>", "0.1.0", "imu: {file: <a>}\n</pre><script>", &alignment, &aligned, &body, &reference, 12,
            sensor};
  }
};

}  // namespace piste::test
