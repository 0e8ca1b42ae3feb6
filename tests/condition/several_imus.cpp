// Several IMUs as one before the filter: what single units do wrong does not reach the mean, and is told.

#include "condition/several_imus.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "piste/math/units.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;

constexpr double kPeriod = 0.01, kStart = 1000;

ImuSensor mt9a() {
  ImuSensor sensor;
  sensor.gyro = {.noise = 0.05 * kDegree, .bias = 0.5 * kDegree, .drift = {}, .scale = 0.01, .range = 300 * kDegree};
  sensor.gyro.drift = {DriftProcess::Kind::kGaussMarkov, 0.01 * kDegree, 200, 0};
  sensor.accel = {.noise = 200e-6 * kStandardGravity, .bias = 0.05, .drift = {}, .scale = 0.02};
  sensor.accel.drift = {DriftProcess::Kind::kGaussMarkov, 0.01, 200, 0};
  sensor.accel.range = 2 * kStandardGravity;
  return sensor;
}

Vector3d true_rate(double t) { return {std::sin(2 * t), 0.7 * std::cos(1.3 * t), 1.2 * std::sin(0.9 * t + 1)}; }
Vector3d true_force(double t) { return {3 * std::sin(2.3 * t), 2 * std::cos(1.1 * t), -9.8 + 4 * std::sin(1.7 * t)}; }

// Units that stand in one place, each with errors of its own.
Recording record(std::size_t units, double duration, Random& random) {
  Recording out;
  const ImuSensor sensor = mt9a();
  for (std::size_t u = 0; u < units; ++u) {
    ImuRecording imu;
    imu.file = "imu.csv";
    const Vector3d gyro_bias = random.vector(sensor.gyro.bias), accel_bias = random.vector(sensor.accel.bias);
    const Vector3d gyro_scale = Vector3d::Ones() + random.vector(sensor.gyro.scale);
    const Vector3d accel_scale = Vector3d::Ones() + random.vector(sensor.accel.scale);
    for (int k = 1; k * kPeriod <= duration; ++k) {
      const double t = k * kPeriod;
      imu.time.push_back(kStart + t);
      imu.gyro.emplace_back(gyro_scale.cwiseProduct(true_rate(t)) + gyro_bias +
                            random.vector(sensor.gyro.noise / std::sqrt(kPeriod)));
      imu.accel.emplace_back(accel_scale.cwiseProduct(true_force(t)) + accel_bias +
                             random.vector(sensor.accel.noise / std::sqrt(kPeriod)));
    }
    (u == 0 ? out.imu : out.further.emplace_back()) = imu;
  }
  return out;
}

ConditioningOptions options_for(std::size_t units) {
  ConditioningOptions options;
  const ImuSensor sensor = mt9a();
  options.gyro_range = sensor.gyro.range;
  options.accel_range = sensor.accel.range;
  for (std::size_t u = 0; u < units; ++u) options.imus.push_back({.name = "unit", .imu = {}, .sensor = sensor});
  return options;
}

// The matrix by which what `log` measured grows with the true rates, beyond 1, by least squares.
Matrix3d gain_of(const Log& log) {
  Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> n = Eigen::Matrix<double, 4, 3>::Zero();
  for (const ImuSample& s : log.imu) {
    const Vector3d u = true_rate(s.time - kStart);
    const Eigen::Vector4d row(1, u.x(), u.y(), u.z());
    N += row * row.transpose();
    n += row * (s.dtheta / s.interval - u).transpose();
  }
  return (N.inverse() * n).bottomRows<3>().transpose();
}

// Scales of units that are turned by some degrees act across the axes of the first too. The mean has all of it, as the
// filter knows it there.
TEST(SeveralImus, TheMeanHasWhatScalesOfTurnedUnitsDoAcrossItsAxes) {
  constexpr double kDuration = 120;
  Random random(5);
  ConditioningOptions options = options_for(3);
  Recording turned;
  Matrix3d across = Matrix3d::Zero();
  for (std::size_t u = 0; u < 3; ++u) {
    const Matrix3d R = u == 0 ? Matrix3d::Identity().eval()
                              : so3_exp(Vector3d(0.05, -0.08, 0.06) * (u == 1 ? 1 : 1.5)).toRotationMatrix();
    const Vector3d scale = 0.02 * Vector3d(1, -1, u == 1 ? 0.5 : -0.5);
    across += R * scale.asDiagonal() * R.transpose() / 3;
    ImuRecording imu;
    imu.file = "imu.csv";
    for (int k = 1; k * kPeriod <= kDuration; ++k) {
      const double t = k * kPeriod;
      const Vector3d rate = R.transpose() * true_rate(t - kPeriod / 2), force = R.transpose() * true_force(t);
      imu.time.push_back(kStart + t);
      imu.gyro.emplace_back(rate + scale.cwiseProduct(rate) + random.vector(mt9a().gyro.noise / std::sqrt(kPeriod)));
      imu.accel.emplace_back(force + random.vector(mt9a().accel.noise / std::sqrt(kPeriod)));
    }
    (u == 0 ? turned.imu : turned.further.emplace_back()) = imu;
    options.imus[u].imu.R_bs = R;
    options.imus[u].sensor.gyro.scale = 0.02;
  }
  Matrix3d beside_diagonal = across;
  beside_diagonal.diagonal().setZero();
  const Matrix3d gain = gain_of(condition_imus(turned, options));
  EXPECT_GT(beside_diagonal.cwiseAbs().maxCoeff(), 1.5e-3);
  EXPECT_LT((gain - across).cwiseAbs().maxCoeff(), 3e-4);
}

// Of the mean with a fault less that without it, over an interval: the largest, in rate and in force.
std::pair<double, double> difference(const Log& a, const Log& b, double from, double to) {
  double rate = 0, force = 0;
  for (std::size_t k = 0; k < std::min(a.imu.size(), b.imu.size()); ++k) {
    if (a.imu[k].time < kStart + from || a.imu[k].time > kStart + to) continue;
    rate = std::max(rate, (a.imu[k].dtheta - b.imu[k].dtheta).norm() / kPeriod);
    force = std::max(force, (a.imu[k].dvel - b.imu[k].dvel).norm() / kPeriod);
  }
  return {rate, force};
}

bool is_told(const ImuReport& unit, ImuFault fault, double from, double to) {
  constexpr double kLate = 0.5;  // s
  return std::ranges::any_of(unit.absences, [&](const ImuAbsence& a) {
    return a.fault == fault && std::abs(a.time.start - kStart - from) < kLate &&
           std::abs(a.time.end - kStart - to) < kLate + (fault == ImuFault::kBiased ? 1.5 : 0);
  });
}

TEST(SeveralImus, FaultsDoNotReachTheMeanAndAreTold) {
  Random random(3);
  const Recording healthy = record(3, 60, random);
  const ConditioningOptions options = options_for(3);
  const Log clean = condition_imus(healthy, options);
  for (const ImuReport& unit : clean.counts.imus) EXPECT_TRUE(unit.absences.empty());
  const auto rows = [](double t) { return static_cast<std::size_t>(std::lround(t / kPeriod)); };

  Recording faulty = healthy;
  ImuRecording& second = faulty.further[0];
  for (std::size_t k = rows(20); k < rows(22); ++k) second.gyro[k] = second.gyro[rows(20)];  // stuck
  for (std::size_t k = rows(30); k < rows(31); ++k) second.accel[k].x() = 1e3;               // clipped
  for (std::size_t k = rows(40); k < rows(43); ++k) second.gyro[k].y() += 5 * kDegree;       // biased
  for (auto* values : {&second.gyro, &second.accel}) {                                       // silent
    values->erase(values->begin() + static_cast<std::ptrdiff_t>(rows(50)),
                  values->begin() + static_cast<std::ptrdiff_t>(rows(52)));
  }
  second.time.erase(second.time.begin() + static_cast<std::ptrdiff_t>(rows(50)),
                    second.time.begin() + static_cast<std::ptrdiff_t>(rows(52)));
  const Log log = condition_imus(faulty, options);
  const ImuReport& unit = log.counts.imus[1];
  EXPECT_TRUE(is_told(unit, ImuFault::kStuck, 20, 22));
  EXPECT_TRUE(is_told(unit, ImuFault::kClipped, 30, 31));
  EXPECT_TRUE(is_told(unit, ImuFault::kBiased, 40, 43));
  EXPECT_TRUE(is_told(unit, ImuFault::kSilent, 50, 52));
  EXPECT_TRUE(log.counts.imus[0].absences.empty());
  EXPECT_TRUE(log.counts.imus[2].absences.empty());
  ASSERT_EQ(log.imu.size(), clean.imu.size());
  // What is left is noise of two units instead of three: some sigmas of a sample.
  const double rate_noise = 5 * mt9a().gyro.noise / std::sqrt(kPeriod);
  const double force_noise = 5 * mt9a().accel.noise / std::sqrt(kPeriod);
  const auto [rate, force] = difference(log, clean, 15, 60);
  EXPECT_LT(rate, rate_noise);
  EXPECT_LT(force, force_noise + 0.02);
  const auto [rate_after, force_after] = difference(log, clean, 55, 60);  // back
  EXPECT_LT(rate_after, 1e-12);
  EXPECT_LT(force_after, 1e-12);
}

// Loggers are not started at once. The offsets of the others are found once all are there, and hold before as well.
TEST(SeveralImus, TheMeanBeforeAUnitBeginsIsThatOfAll) {
  constexpr int kLate = 3000;  // rows
  Random random(7);
  const Recording whole = record(2, 90, random);
  Recording late = whole;
  ImuRecording& second = late.further[0];
  for (auto* values : {&second.gyro, &second.accel}) values->erase(values->begin(), values->begin() + kLate);
  second.time.erase(second.time.begin(), second.time.begin() + kLate);
  const Log clean = condition_imus(whole, options_for(2)), log = condition_imus(late, options_for(2));
  ASSERT_EQ(log.imu.size(), clean.imu.size());
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();
  double added = 0;
  constexpr std::size_t kFrom = 100, kTo = kLate - 100;
  for (std::size_t k = kFrom; k < kTo; ++k) {
    rate += (log.imu[k].dtheta - clean.imu[k].dtheta) / (kPeriod * (kTo - kFrom));
    force += (log.imu[k].dvel - clean.imu[k].dvel) / (kPeriod * (kTo - kFrom));
    ASSERT_TRUE(log.imu[k].interpolated) << k;
    added = std::max<double>(added, log.imu[k].interpolated->gyro);
  }
  EXPECT_LT(rate.cwiseAbs().maxCoeff(), 0.1 * mt9a().gyro.bias);
  EXPECT_LT(force.cwiseAbs().maxCoeff(), 0.1 * mt9a().accel.bias);
  EXPECT_LT(added, 5 * mt9a().gyro.noise);  // with nothing known of the offset, a hundred times as much
}

TEST(SeveralImus, ABiasedUnitOfThreeIsFoundAndNoOther) {
  constexpr int kRuns = 1000;
  constexpr double kLength = 16, kFault = 12;
  const ConditioningOptions options = options_for(3);
  int found = 0, false_alarms = 0;
  for (int run = 0; run < kRuns; ++run) {
    Random random(100 + static_cast<std::uint64_t>(run));
    Recording recording = record(3, kLength, random);
    ImuRecording& second = recording.further[0];
    const bool gyro = run % 2 == 0;
    const int axis = run % 3;
    for (std::size_t k = 0; k < second.time.size(); ++k) {  // by three sigmas of its turn-on bias
      if (second.time[k] - kStart <= kFault) continue;
      (gyro ? second.gyro : second.accel)[k](axis) += gyro ? 1.5 * kDegree : 0.15;
    }
    const Log log = condition_imus(recording, options);
    bool seen = false;
    for (std::size_t u = 0; u < 3; ++u) {
      for (const ImuAbsence& a : log.counts.imus[u].absences) {
        if (a.fault != ImuFault::kBiased) continue;
        if (u == 1 && a.gyro == gyro && a.time.end > kStart + kFault) {
          seen = true;
        } else {
          ++false_alarms;
        }
      }
    }
    found += seen ? 1 : 0;
  }
  EXPECT_GE(found, 999);
  EXPECT_LE(false_alarms, 1);  // in 1.6e6 epochs
}

}  // namespace
}  // namespace piste
