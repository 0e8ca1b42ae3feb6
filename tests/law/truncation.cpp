// What coning costs a filter that samples it coarsely is in what it claims.

#include "walker/truncation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "piste/filter/run.h"
#include "piste/math/units.h"
#include "support/random.h"

namespace piste::test {
namespace {

constexpr double kDuration = 60;  // s

// A body that stays in its place, and whose axis describes a cone about a level axis, so that the drift is a tilt.
struct Cone {
  double frequency = 5, rate = 60 * kDegree;  // Hz; rms of each of the two rates [rad/s]
  World world{{0.8, 0.1, 500}};
  Matrix3d R_wn = world.rotation_wn(Vector3d::Zero());
  Gravity gravity = world.gravity(Vector3d::Zero());

  double turned() const { return 2 * std::numbers::pi * frequency; }
  double angle() const { return std::sqrt(2.0) * rate / turned(); }
  Vector3d cone(double t) const { return angle() * Vector3d(0, std::cos(turned() * t), std::sin(turned() * t)); }
  Quaterniond attitude(double t) const { return Quaterniond(R_wn) * so3_exp(cone(t)); }

  ImuSample sample(double start, double end) const {
    constexpr std::array<double, 3> node{-0.7745966692414834, 0, 0.7745966692414834};
    constexpr std::array<double, 3> weight{5.0 / 9, 8.0 / 9, 5.0 / 9};
    constexpr int kPieces = 8;
    ImuSample s;
    s.time = end;
    s.interval = end - start;
    const double half = (end - start) / (2 * kPieces);
    for (int piece = 0; piece < kPieces; ++piece) {
      for (std::size_t i = 0; i < node.size(); ++i) {
        const double t = start + (2 * piece + 1 + node[i]) * half;
        const Matrix3d R_bw = attitude(t).toRotationMatrix().transpose();
        const Vector3d change = turned() * angle() * Vector3d(0, -std::sin(turned() * t), std::cos(turned() * t));
        s.dtheta += weight[i] * half * (so3_left_jacobian(-cone(t)) * change + R_bw * world.earth_rate());
        s.dvel -= weight[i] * half * (R_bw * gravity.value);
      }
    }
    return s;
  }
};

ImuSensor tactical() {
  ImuSensor sensor;
  sensor.gyro.noise = 6.3e-4 * kDegree;
  sensor.accel.noise = 50e-6 * kStandardGravity;
  sensor.gyro.drift = sensor.accel.drift = {DriftProcess::Kind::kGaussMarkov, 1e-12, 1000, 0};
  return sensor;
}

// Share of the rows inside 3 sigma in each axis, and the mean square of the errors over their sigmas.
struct Within {
  double rows = 0, inside = 0, square = 0;
};

Within coned(double frequency, double rate, double sampling, std::uint64_t seed) {
  const Cone cone{.frequency = frequency, .rate = rate};
  Random random(seed);
  Log log;
  log.world = cone.world;
  const double dt = 1 / sampling;
  const ImuSensor sensor = tactical();
  for (int k = 1; k <= kDuration * sampling; ++k) {
    ImuSample s = cone.sample((k - 1) * dt, k * dt);
    s.dtheta += random.vector(sensor.gyro.noise * std::sqrt(dt));
    s.dvel += random.vector(sensor.accel.noise * std::sqrt(dt));
    log.imu.push_back(s);
  }
  FilterOptions options;
  options.sensor = sensor;
  options.estimate.clear();
  options.gnss.clear();
  Start start;
  start.time = 0;
  start.x.q_wb = cone.attitude(0);
  start.covariance.diagonal().setConstant(1e-12);
  const FilterRun run = run_filter(log, options, start, Keep::kNothing);
  Within w;
  for (std::size_t i = 0; i < run.solution.size(); ++i) {
    const Estimate x = run.solution.estimate(i);
    const auto sigmas = run.solution.sigmas(i);
    const Vector3d position = (cone.R_wn.transpose() * x.p_wb).cwiseQuotient(sigmas.position);
    const Vector3d velocity = (cone.R_wn.transpose() * x.v_wb).cwiseQuotient(sigmas.velocity);
    for (const Vector3d& z : {position, velocity}) {
      for (const double e : z) {
        w.rows += 1;
        w.inside += std::abs(e) < 3;
        w.square += e * e;
      }
    }
  }
  w.inside /= w.rows;
  w.square /= w.rows;
  const Estimate last = run.solution.estimate(run.solution.size() - 1);
  fmt::print("{} Hz at {} Hz: {:.2f} m off of {:.2f} m, {:.3f} inside 3 sigma, mean square {:.2f}\n", frequency,
             sampling, last.p_wb.norm(), run.solution.sigmas(run.solution.size() - 1).position.norm(), w.inside,
             w.square);
  return w;
}

TEST(Truncation, OfConingIsClaimed) {
  for (const double frequency : {2.0, 5.0, 10.0}) {
    for (const double sampling : {50.0, 100.0}) {
      Within all;
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const Within w = coned(frequency, 60 * kDegree, sampling, seed);
        all.inside += w.inside / 4;
        all.square += w.square / 4;
      }
      EXPECT_GE(all.inside, 0.97) << frequency << " " << sampling;
      EXPECT_GE(all.square, 0.1) << frequency << " " << sampling;
      EXPECT_LE(all.square, 1.5) << frequency << " " << sampling;
    }
  }
}

// Errors of random sign add up as a random walk: what is claimed is a few times the sum of their squares, for hours.
TEST(Truncation, OfAShakeThatAlternatesDoesNotLast) {
  ImuSensor sensor = tactical();
  sensor.gyro.noise = sensor.accel.noise = 1e-12;
  Random random(1);
  Truncation truncation;
  constexpr double kStep = 0.01;
  std::array<Vector3d, 5> rates;
  double claimed = 0, squares = 0;
  for (int k = 1; k <= 360000; ++k) {
    std::shift_left(rates.begin(), rates.end(), 1);
    rates.back() = random.vector(1);
    ImuSample s;
    s.time = k * kStep;
    s.interval = kStep;
    s.dtheta = kStep * rates.back();
    claimed += kStep * truncation.add(&s, sensor).gyro.sum();
    if (k < 5) continue;
    const Vector3d bend = (rates[4] - rates[0]) / (4 * kStep) - (rates[3] - rates[1]) / (2 * kStep);
    squares += (kStep * kStep * kStep / 30 * rates[2].cross(bend)).squaredNorm();
  }
  EXPECT_GT(claimed, 0.5 * squares);
  EXPECT_LT(claimed, 20 * squares);  // the largest of a walk so far is more than the walk
}

TEST(Truncation, IsNoneOfABodyThatStandsOrOfSamplesApart) {
  const ImuSensor sensor = tactical();
  Truncation still;
  ImuSample sample;
  sample.interval = 0.01;
  sample.dvel = {0, 0, -0.098};
  for (int k = 1; k < 100; ++k) {
    sample.time = 0.01 * k;
    const StepNoise noise = still.add(&sample, sensor);
    EXPECT_EQ(noise.gyro, Vector3d::Zero());
    EXPECT_EQ(noise.accel, Vector3d::Zero());
  }
  const Cone cone;
  Truncation turning;
  for (int k = 1; k < 100; ++k) {  // every fourth is lost
    if (k % 4 == 0) continue;
    const ImuSample s = cone.sample(0.01 * (k - 1), 0.01 * k);
    EXPECT_EQ(turning.add(&s, sensor).gyro, Vector3d::Zero()) << k;
  }
  EXPECT_EQ(turning.add(nullptr, sensor).gyro, Vector3d::Zero());
}

}  // namespace
}  // namespace piste::test
