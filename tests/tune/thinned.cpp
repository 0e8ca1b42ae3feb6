#include "tune/thinned.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "piste/math/earth.h"
#include "piste/math/so3.h"
#include "piste/model/strapdown.h"

namespace piste {
namespace {

constexpr double kInterval = 0.005, kLength = 20;

// A body that turns slowly, and shakes in a cone of 12 Hz.
Log shaken() {
  Log log;
  log.world = World({0.8, 0.1, 400});
  const double shakes = 2 * 3.14159265358979 * 12;
  for (double t = kInterval; t < kLength; t += kInterval) {
    ImuSample s;
    s.time = t;
    s.interval = kInterval;
    s.dtheta = kInterval * Vector3d(std::cos(shakes * t), std::sin(shakes * t), 0.2 * std::sin(0.8 * t));
    s.dvel = kInterval * Vector3d(2 * std::sin(shakes * t), std::cos(0.5 * t), -9.8 + std::cos(shakes * t));
    log.imu.push_back(s);
  }
  return log;
}

Estimate mechanized(const Log& log) {
  Estimate x;
  x.q_wb = Quaterniond::Identity();
  x.v_wb = x.p_wb = Vector3d::Zero();
  const Gravity gravity = log.world.gravity(x.p_wb);
  const auto& imu = log.imu;
  for (std::size_t k = 0; k < imu.size(); ++k) {
    const ImuStep step = make_step(k > 0 ? &imu[k - 1] : nullptr, imu[k], k + 1 < imu.size() ? &imu[k + 1] : nullptr);
    mechanize(x, step, log.world.earth_rate(), gravity);
  }
  return x;
}

TEST(Thinned, KeepsWhatConingAndScullingAdd) {
  const Log log = shaken(), thin = thinned(log);
  ASSERT_LT(thin.imu.size(), log.imu.size() / 4);
  const Estimate all = mechanized(log), few = mechanized(thin);
  const double cone = kLength * 1.0 / (2 * 2 * 3.14159265358979 * 12);  // rad: ω²/2Ω for a rate of 1 rad/s
  EXPECT_LT(so3_log(all.q_wb.conjugate() * few.q_wb).norm(), 2e-4 * cone);
  EXPECT_LT((all.v_wb - few.v_wb).norm(), 2e-3);
}

TEST(Thinned, EndsGroupsAtWhatIsNotAlike) {
  Log log = shaken();
  log.imu[100].gap = GapNoise{1, 1};
  log.imu[1000].interpolated = GapNoise{1, 1};
  log.imu[2000].clipped_gyro = 1;
  for (std::size_t k = 3000; k < 3501; ++k) log.imu[k].at_rest = true;
  const Log thin = thinned(log);
  double length = 0, rest = 0;
  int gaps = 0, spikes = 0, clipped = 0;
  for (const ImuSample& s : thin.imu) {
    length += s.interval;
    if (s.at_rest) rest += s.interval;
    gaps += s.gap ? 1 : 0;
    spikes += s.interpolated ? 1 : 0;
    clipped += s.clipped_gyro;
    if (s.gap || s.interpolated || s.clipped_gyro != 0) {
      EXPECT_DOUBLE_EQ(s.interval, kInterval);
    }
  }
  EXPECT_NEAR(length, kInterval * static_cast<double>(log.imu.size()), 1e-9);
  EXPECT_NEAR(rest, 501 * kInterval, 1e-9);
  EXPECT_EQ(gaps + spikes + clipped, 3);
}

// Rates of white noise alone are summed as far as is allowed, rates that change fast not at all.
TEST(Thinned, TakesAsManyAsTheMotionAllows) {
  Log fast = shaken();
  for (ImuSample& s : fast.imu) {
    s.dtheta = kInterval * Vector3d(std::sin(30 * s.time), 0, 0);
  }
  EXPECT_EQ(thinned(fast).imu.size(), fast.imu.size());
  Log slow = shaken();
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 1e-4);
  for (ImuSample& s : slow.imu) s.dtheta = Vector3d(noise(random), noise(random), noise(random));
  EXPECT_LT(thinned(slow).imu.size(), slow.imu.size() / 10);
}

}  // namespace
}  // namespace piste
