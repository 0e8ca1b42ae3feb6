// A real MEMS-IMU in a car against itself: its raw log, in sensor axes and milliseconds since power-up, with the noise
// and the biases of another sensor added, beside the same log turned
// and put on GPS time by the recordist.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "piste/condition/pipeline.h"
#include "piste/condition/time_sync.h"
#include "piste/configuration/sensor_file.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/datasets.h"
#include "support/places.h"
#include "support/random.h"

namespace piste::test {
namespace {

constexpr double kGravity = 9.80665;
const Vector3d kGyroBias(0.4 * kDegree, -0.3 * kDegree, 0.2 * kDegree);

ImuRecording raw_log(double gyro_noise, double accel_noise) {
  ImuRecording imu;
  imu.file = (datasets() / "drive/imu_1934.csv").string();
  std::ifstream in(imu.file);
  Random random(1);
  for (std::string line; std::getline(in, line);) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    Vector3d f, w;
    double milliseconds = 0;
    std::istringstream(line) >> f.x() >> f.y() >> f.z() >> w.x() >> w.y() >> w.z() >> milliseconds;
    imu.time.push_back(1e-3 * milliseconds);
    imu.gyro.emplace_back(kDegree * w + kGyroBias + random.vector(gyro_noise));
    imu.accel.emplace_back(kGravity * f + random.vector(accel_noise));
  }
  return imu;
}

TEST(DriveAlignment, FindsTheRecordistsMountingAndClock) {
  PISTE_REQUIRE_DATASETS();
  const ImuSensor sensor = read_sensor(source_folder() + "/config/sensors/mems_car.yaml");
  const auto reference = condition_imu(read_imu({(datasets() / "drive/imu.txt").string(), LogFormat::kKfGins}), {}).imu;
  const auto body = condition_imu(raw_log(0.5 * kDegree, 0.1), {}).imu;
  const Alignment a = align(body, reference, {.sensor = sensor});

  // b is the raw sensor, r the car. The recordist's roll, pitch and heading turn r into b.
  const Quaterniond stated = from_euler(kDegree * Vector3d(180, -6.79, 185.35)).conjugate();
  const Vector3d apart = kDegreesPerRadian * so3_log(stated * a.q_rb.conjugate()),
                 sigma = kDegreesPerRadian * a.sigma(AlignmentLayout::kBoresight);
  fmt::print(
      "boresight {:.3f} {:.3f} {:.3f} deg beside the stated one, sigma {:.3f}; offset {:.6f} ± {:.6f} s, drift "
      "{:.2f} ppm\n",
      apart.x(), apart.y(), apart.z(), sigma.maxCoeff(), a.clock_offset,
      std::sqrt(a.variance(AlignmentLayout::kClockOffset)), 1e6 * a.clock_drift);
  EXPECT_TRUE(a.undetermined.empty());
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(apart(i)), 4 * sigma(i)) << i;
  EXPECT_LT(apart.norm(), 0.1);
  EXPECT_LT((a.gyro_bias - kGyroBias).cwiseAbs().maxCoeff(), 4 * a.sigma(AlignmentLayout::kGyroBias).maxCoeff());
  // Both are one sensor: no lever arm.
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(a.p_rb_r(i)), 4 * a.sigma(AlignmentLayout::kLeverArm)(i));

  // The same without the added noise is the truth, as far as clocks go.
  const Alignment exact = align(condition_imu(raw_log(0, 0), {}).imu, reference, {.sensor = sensor});
  EXPECT_LT(std::abs(a.clock_offset - exact.clock_offset), 4 * std::sqrt(a.variance(AlignmentLayout::kClockOffset)));
  EXPECT_LT(std::abs(a.clock_drift - exact.clock_drift), 4 * std::sqrt(a.variance(AlignmentLayout::kClockDrift)));
}

}  // namespace
}  // namespace piste::test
