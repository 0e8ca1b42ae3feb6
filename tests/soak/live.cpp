// A real-time session for hours: memory that does not grow, covariances that stay positive definite, sigmas that stay
// true. PISTE_SOAK_HOURS says how many hours of time it simulates, a tenth unless stated, and PISTE_SOAK_RATE at how
// many samples a second, 100 unless stated. Neither motion nor logs are stored.

#include "piste/live/live.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include "piste/math/units.h"
#include "piste/sim/scenario.h"
#include "support/places.h"
#include "support/random.h"

namespace piste::test {
namespace {

// Half a minute of rest, then round a circle of 80 m for ever, rolling and pitching. All is a function of an inner time
// u that begins to run smoothly.
class RoundAndRound {
 public:
  struct State {
    Vector3d position, velocity, acceleration;  // in w
    Quaterniond q_wb;
  };
  State at(double t) const {
    const double ramp = std::clamp((t - kRest) / kRamp, 0.0, 1.0);
    const double u = t < kRest + kRamp ? 0.5 * kRamp * ramp * ramp : t - kRest - 0.5 * kRamp,
                 slope = t < kRest + kRamp ? ramp : 1, change = ramp > 0 && ramp < 1 ? 1 / kRamp : 0;
    const double phi = kTurn * u + kSwing * std::sin(kCycle * u), turn = kTurn + kSwing * kCycle * std::cos(kCycle * u),
                 bend = -kSwing * kCycle * kCycle * std::sin(kCycle * u);
    const Vector3d out(std::cos(phi), std::sin(phi), 0), along(-std::sin(phi), std::cos(phi), 0);
    State s;
    s.position = kRadius * out + Vector3d(0, 0, kHeave * std::sin(kWave * u));
    const Vector3d by_u = kRadius * turn * along + Vector3d(0, 0, kHeave * kWave * std::cos(kWave * u)),
                   by_u2 = kRadius * (bend * along - turn * turn * out) -
                           Vector3d(0, 0, kHeave * kWave * kWave * std::sin(kWave * u));
    s.velocity = slope * by_u;
    s.acceleration = change * by_u + slope * slope * by_u2;
    s.q_wb = from_euler({0.15 * std::sin(0.9 * u), 0.08 * std::sin(0.6 * u),
                         std::remainder(phi, 2 * std::numbers::pi) + std::numbers::pi / 2});
    return s;
  }

 private:
  static constexpr double kRest = 30, kRamp = 8, kRadius = 80, kTurn = 0.12, kSwing = 0.4, kCycle = 0.21, kHeave = 1.5,
                          kWave = 0.13;
};

// Resident memory of this process [MiB].
double resident() {
  std::ifstream file("/proc/self/statm");
  double size = 0, pages = 0;
  file >> size >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

double stated(const char* name, double unless) {
  const char* value = std::getenv(name);
  return value != nullptr ? std::atof(value) : unless;
}

TEST(Soak, LiveForHours) {
  constexpr double kFixes = 0.25, kWhite = 0.02, kLeastShare = 0.97;
  const double hertz = stated("PISTE_SOAK_RATE", 100), interval = 1 / hertz;
  const World world({46 * kDegree, 7 * kDegree, 1500});
  const ImuSensor sensor = read_scenario(kSource / "config/scenarios/ski.yaml").imus.front().sensor;
  LiveOptions options;
  options.conditioning.imu.instantaneous = true;
  options.filter.sensor = sensor;
  options.filter.gnss = {{.name = "gnss", .lever_arm = {0, 0, -0.4}, .drift = {}}};
  options.filter.estimate = {Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
                             Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};
  Live live(options);
  const RoundAndRound motion;
  Random random(17);
  const Vector3d gyro_bias = random.vector(sensor.gyro.bias), accel_bias = random.vector(sensor.accel.bias);
  Vector3d gyro_drift = random.vector(sensor.gyro.drift.sigma), accel_drift = random.vector(sensor.accel.drift.sigma);
  const auto wander = [&](Vector3d& drift, const DriftProcess& process) {
    const double stays = std::exp(-interval / process.correlation_time);
    drift = stays * drift + random.vector(process.sigma * std::sqrt(1 - stays * stays));
  };
  const double end = 3600 * stated("PISTE_SOAK_HOURS", 0.1), settled = 600;
  double next_fix = kFixes, next_look = 60, memory = 0, inside = 0, looks = 0, squares = 0;
  for (std::size_t k = 1; k < static_cast<std::size_t>(end / interval); ++k) {
    const double t = interval * static_cast<double>(k);
    const RoundAndRound::State s = motion.at(t);
    constexpr double kStep = 1e-4;
    const Matrix3d R_bw = s.q_wb.conjugate().toRotationMatrix();
    const Vector3d turning =
        so3_log((motion.at(t - kStep).q_wb.conjugate() * motion.at(t + kStep).q_wb).normalized()) / (2 * kStep);
    wander(gyro_drift, sensor.gyro.drift);
    wander(accel_drift, sensor.accel.drift);
    const Vector3d rate = R_bw * world.earth_rate() + turning,
                   force = R_bw * (s.acceleration + 2 * world.earth_rate().cross(s.velocity) -
                                   world.gravity(s.position).value);
    live.add({t, rate + gyro_bias + gyro_drift + random.vector(sensor.gyro.noise / std::sqrt(interval)),
              force + accel_bias + accel_drift + random.vector(sensor.accel.noise / std::sqrt(interval))});
    if (t + 1e-9 >= next_fix) {
      next_fix += kFixes;
      GeodeticFix fix;
      fix.time = t;
      fix.position = world.to_geodetic(s.position + s.q_wb * options.filter.gnss[0].lever_arm + random.vector(kWhite));
      fix.sigma_position.setConstant(kWhite);
      live.add(0, fix);
    }
    if (t < next_look) continue;
    next_look += 1;
    const auto state = live.state();
    ASSERT_TRUE(state && live.filter() != nullptr) << t;
    const Vector3d truth = motion.at(state->time).position, error = world.from_geodetic(state->position) - truth;
    ASSERT_TRUE(error.allFinite()) << t;
    const Eigen::LLT<Eigen::MatrixXd> factor(live.filter()->covariance());
    ASSERT_EQ(factor.info(), Eigen::Success) << "the covariance is not positive definite at " << t << " s";
    const Vector3d by_sigma = error.cwiseQuotient(state->sigmas.position);
    squares += by_sigma.squaredNorm() / 3;
    inside += static_cast<double>((by_sigma.array().abs() < 3).count()) / 3;
    ++looks;
    if (memory == 0 && t > settled) memory = resident();
  }
  fmt::print(
      "figure: {:.2f} h at {:.0f} Hz, {:.2f} % inside 3 sigma, mean square {:.3f}; {:.1f} MiB, {:.1f} after ten "
      "minutes\n",
      end / 3600, hertz, 100 * inside / looks, squares / looks, resident(), memory);
  EXPECT_GE(inside / looks, kLeastShare);
  EXPECT_GT(squares / looks, 0.5);
  EXPECT_LT(squares / looks, 1.5);
  if (memory > 0) {
    EXPECT_LT(resident(), memory + 4) << "MiB";
  }
}

}  // namespace
}  // namespace piste::test
