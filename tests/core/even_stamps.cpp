// Rows of an IMU on the even clock of its samples: stamps that are rounded, late, or true.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/recording.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;

constexpr double kPeriod = 0.01;

// What turns at `t`: far slower than the rows come, and steep enough to tell when a sample was taken.
Vector3d rate(double t) { return {std::sin(9 * t), std::cos(7 * t + 1), std::sin(5 * t) * std::cos(3 * t)}; }

// Samples taken at `taken` and stamped `stamped`, with white noise.
ImuRecording recording(const std::vector<double>& taken, const std::vector<double>& stamped) {
  Random random(3);
  ImuRecording imu;
  imu.time = stamped;
  for (const double t : taken) {
    imu.gyro.emplace_back(rate(t) + 1e-3 * random.vector());
    imu.accel.emplace_back(5 * rate(t + 2) + 1e-2 * random.vector());
  }
  return imu;
}

std::vector<double> clock(std::size_t count, double drift = 0) {
  std::vector<double> time;
  for (std::size_t i = 0; i < count; ++i) time.push_back(100 + (1 + drift) * kPeriod * static_cast<double>(i));
  return time;
}

std::vector<double> jittered(std::vector<double> time, double by) {
  Random random(4);
  for (double& t : time) t += by * (2 * random.uniform() - 1);
  return time;
}

double rms_apart(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0, mean = 0;
  for (std::size_t i = 0; i < a.size(); ++i) mean += (a[i] - b[i]) / static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i] - mean) * (a[i] - b[i] - mean);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(EvenStamps, ScatterAboutTheSensorsClockIsTakenOut) {
  const std::vector<double> truth = clock(6000, 3e-4);
  ImuRecording imu = recording(truth, jittered(truth, 0.004));
  even_stamps(imu);
  EXPECT_NEAR(imu.stamp_jitter, 0.004 / std::sqrt(3), 1e-4);
  EXPECT_LT(rms_apart(imu.time, truth), 3e-4);
}

TEST(EvenStamps, RoundedStampsAreMadeEven) {
  std::vector<double> truth;
  for (int i = 0; i < 5000; ++i) truth.push_back(243261.7 + i / 133.0);
  std::vector<double> rounded = truth;
  for (double& t : rounded) t = 1e-3 * std::round(1e3 * t);
  ImuRecording imu = recording(truth, rounded);
  even_stamps(imu);
  EXPECT_LT(rms_apart(imu.time, truth), 5e-5);
}

TEST(EvenStamps, MissingRowsAreCounted) {
  std::vector<double> truth = clock(6000);
  Random random(8);
  std::erase_if(truth, [&](double) { return random.uniform() < 0.01; });
  truth.erase(truth.begin() + 2000, truth.begin() + 2700);  // seven seconds: a logger may begin anew there
  for (auto t = truth.begin() + 2000; t != truth.end(); ++t) *t += 0.004;
  ImuRecording imu = recording(truth, jittered(truth, 0.002));
  even_stamps(imu);
  EXPECT_GT(imu.stamp_jitter, 0);
  EXPECT_LT(rms_apart(imu.time, truth), 3e-4);
}

TEST(EvenStamps, SamplesThatWereTakenUnevenlyKeepTheirStamps) {
  const std::vector<double> taken = jittered(clock(6000), 0.004);
  ImuRecording imu = recording(taken, taken);
  even_stamps(imu);
  EXPECT_EQ(imu.stamp_jitter, 0);
  EXPECT_EQ(imu.time, taken);
}

TEST(EvenStamps, AnEvenLogKeepsItsBytes) {
  const std::vector<double> truth = clock(3000), nearly = jittered(truth, 1e-4);
  ImuRecording imu = recording(truth, nearly);
  even_stamps(imu);
  EXPECT_EQ(imu.time, nearly);
}

TEST(EvenStamps, IncrementsAndFewRowsAreLeftAlone) {
  const std::vector<double> truth = clock(3000), late = jittered(truth, 0.003);
  ImuRecording increments = recording(truth, late);
  increments.increments = true;
  even_stamps(increments);
  EXPECT_EQ(increments.time, late);
  const std::vector<double> few(late.begin(), late.begin() + 9);
  ImuRecording shortest = recording({truth.begin(), truth.begin() + 9}, few);
  even_stamps(shortest);
  EXPECT_EQ(shortest.time, few);
}

}  // namespace
}  // namespace piste
