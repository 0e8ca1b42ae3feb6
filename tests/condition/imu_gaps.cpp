// The line over a gap, and its noise: that of a sine by hand, and on a recorded run what the line really misses.

#include "condition/imu_gaps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "piste/condition/pipeline.h"
#include "piste/core/options.h"
#include "piste/io/log_io.h"
#include "support/places.h"

namespace piste::test {
namespace {

constexpr double kRate = 100, kEdge = 0.2;  // Hz, s

/// Samples of a signal given by its integral over an interval.
template <class Integral>
std::vector<ImuSample> samples(double length, Integral&& integral) {
  std::vector<ImuSample> imu;
  for (int i = 1; i <= static_cast<int>(length * kRate); ++i) {
    const double time = i / kRate, interval = 1 / kRate;
    const Vector3d value = integral(time) - integral(time - interval);
    imu.push_back({.time = time, .interval = interval, .dtheta = value, .dvel = 10 * value});
  }
  return imu;
}

/// The samples first, first + 1, …, as a gap that is yet to be filled.
std::vector<ImuSample> with_gap(std::vector<ImuSample> imu, std::size_t first, std::size_t count) {
  for (std::size_t i = first; i < first + count; ++i) {
    imu[i] = {.time = imu[i].time, .interval = imu[i].interval, .gap = GapNoise{}};
  }
  return imu;
}

std::vector<ImuSample> filled(const std::vector<ImuSample>& imu, std::size_t first, std::size_t count) {
  std::vector<ImuSample> out = with_gap(imu, first, count);
  fill_gaps(out);
  return out;
}

std::vector<ImuSample> ramp(double length) {
  return samples(length, [](double t) { return Vector3d(t * t, -2 * t * t + t, 3); });
}

TEST(ImuGaps, CautionScalesTheNoise) {
  const std::vector<ImuSample> imu =
      samples(60, [](double t) { return Vector3d(std::cos(5 * t), std::sin(7 * t), t); });
  std::vector<ImuSample> usual = with_gap(imu, 3000, 50), bold = usual;
  fill_gaps(usual);
  fill_gaps(bold, {.caution = 1});
  EXPECT_GT(usual[3000].gap->gyro, 0);
  EXPECT_DOUBLE_EQ(usual[3000].gap->gyro, 2 * bold[3000].gap->gyro);
}

TEST(ImuGaps, ARampIsFoundAgain) {
  const std::vector<ImuSample> imu = ramp(60);
  const std::vector<ImuSample> out = filled(imu, 3000, 50);
  for (std::size_t i = 0; i < imu.size(); ++i) {
    EXPECT_LT((out[i].dtheta - imu[i].dtheta).norm(), 1e-11) << i;
    EXPECT_LT((out[i].dvel - imu[i].dvel).norm(), 1e-10) << i;
    ASSERT_EQ(out[i].gap.has_value(), i >= 3000 && i < 3050) << i;
  }
  EXPECT_LT(out[3000].gap->gyro, 1e-9);
  EXPECT_LT(out[3000].gap->accel, 1e-8);
}

// Of a·sin(ωt) the line through the edges' means misses, over a gap of length T, a times a sine of the gap's place.
TEST(ImuGaps, ASinesNoiseIsWhatTheLineMisses) {
  constexpr double kOmega = 2 * std::numbers::pi * 0.4;
  const Vector3d amplitude(1, 0.5, 0.2);
  const std::vector<ImuSample> imu =
      samples(100, [&](double t) { return Vector3d(-amplitude / kOmega * std::cos(kOmega * t)); });
  for (const std::size_t count : {10u, 50u, 100u, 200u}) {
    const double length = static_cast<double>(count) / kRate;
    const double edge = std::sin(kOmega * kEdge / 2) / (kOmega * kEdge / 2);
    const double missed =
        2 * std::sin(kOmega * length / 2) / kOmega - length * edge * std::cos(kOmega * (length + kEdge) / 2);
    const double expected = 2 * std::abs(missed) / std::sqrt(2 * length);
    const std::vector<ImuSample> out = filled(imu, 5000, count);
    EXPECT_NEAR(out[5000].gap->gyro, expected, 0.05 * expected) << count;
    EXPECT_NEAR(out[5000].gap->accel, 10 * expected, 0.5 * expected) << count;
  }
}

TEST(ImuGaps, WithoutNeighboursTheNoiseIsTheLargest) {
  for (const std::size_t first : {std::size_t{0}, std::size_t{10}, std::size_t{250}}) {
    const std::vector<ImuSample> out = filled(ramp(3), first, 50);
    EXPECT_EQ(out[first].gap->gyro, 1);
    EXPECT_EQ(out[first].gap->accel, 3);
  }
}

TEST(ImuGaps, AtTheEndsTheOtherSideHolds) {
  const std::vector<ImuSample> imu = samples(30, [](double t) { return Vector3d(t, 0, -t); });
  for (const std::size_t first : {std::size_t{0}, imu.size() - 20}) {
    const std::vector<ImuSample> out = filled(imu, first, 20);
    for (std::size_t i = first; i < first + 20; ++i) {
      EXPECT_LT((out[i].dtheta - imu[i].dtheta).norm(), 1e-12) << i;
    }
  }
}

TEST(ImuGaps, ASampleBetweenTwoGapsServesBoth) {
  std::vector<ImuSample> imu = with_gap(with_gap(ramp(60), 3000, 20), 3021, 20);
  fill_gaps(imu);
  const std::vector<ImuSample> measured = ramp(60);
  for (std::size_t i = 3000; i < 3041; ++i) {
    EXPECT_LT((imu[i].dtheta - measured[i].dtheta).norm(), 1e-9) << i;
  }
}

// Gaps all over the shipped run: what the line missed, in sigmas of its noise. The noise is twice what the
// neighbourhood says, so half a sigma is right where the run is of one kind.
TEST(ImuGaps, NoiseOfARecordedRunCoversWhatIsMissed) {
  LogFile file;
  file.file = source_folder() + "/data/ski_run/mt9a_1.csv";
  const std::vector<ImuSample> run = condition_imu(read_imu(file), {}).imu;
  for (const std::size_t count : {5u, 20u, 50u, 100u, 200u}) {
    double turn = 0, push = 0, gaps = 0;
    for (std::size_t first = 1000; first + 2000 < run.size(); first += 170, ++gaps) {
      const std::vector<ImuSample> out = filled(run, first, count);
      Vector3d missed_turn = Vector3d::Zero(), missed_push = Vector3d::Zero();
      for (std::size_t i = first; i < first + count; ++i) {
        missed_turn += out[i].dtheta - run[i].dtheta;
        missed_push += out[i].dvel - run[i].dvel;
      }
      const double length = static_cast<double>(count) / kRate;
      turn += missed_turn.squaredNorm() / (3 * out[first].gap->gyro * out[first].gap->gyro * length);
      push += missed_push.squaredNorm() / (3 * out[first].gap->accel * out[first].gap->accel * length);
    }
    for (const double part : {std::sqrt(turn / gaps), std::sqrt(push / gaps)}) {
      EXPECT_GT(part, 0.25) << count;
      EXPECT_LT(part, 0.75) << count;
    }
    std::printf("%zu samples: %.2f and %.2f sigma\n", count, std::sqrt(turn / gaps), std::sqrt(push / gaps));
  }
}

}  // namespace
}  // namespace piste::test
