// The least squares of an alignment: its manifold, and its information against differences through boxplus.

#include "condition/alignment_problem.h"

#include <gtest/gtest.h>

#include "condition/rotation_manifold.h"
#include "support/random.h"

namespace piste::test {
namespace {

using Layout = AlignmentLayout;
using Vector20d = Eigen::Matrix<double, Layout::kSize, 1>;

/// Samples of an IMU that shakes in all axes, in no relation to any truth.
std::vector<ImuSample> shaken(double start, double duration, double rate, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::array<Vector3d, 3>> waves;  // amplitudes of rate and force, and (frequency, phase, phase)
  for (int i = 0; i < 6; ++i) {
    waves.push_back({random.vector(0.5), random.vector(2),
                     Vector3d(4 * random.uniform() + 0.2, 6 * random.uniform(), 6 * random.uniform())});
  }
  std::vector<ImuSample> imu;
  for (int k = 1; k <= std::lround(duration * rate); ++k) {
    ImuSample s;
    s.interval = 1 / rate;
    s.time = start + k * s.interval;
    for (const auto& [w, f, wave] : waves) {
      s.dtheta += s.interval * std::sin(6.28 * wave.x() * s.time + wave.y()) * w;
      s.dvel += s.interval * std::sin(6.28 * wave.x() * s.time + wave.z()) * f;
    }
    imu.push_back(s);
  }
  return imu;
}

AlignmentState moved(AlignmentState x, const Vector20d& e) {
  x.clock += e.head<2>();
  x.q_rb = so3_exp(e.segment<3>(Layout::kBoresight)) * x.q_rb;
  x.p_rb_r += e.segment<3>(Layout::kLeverArm);
  x.gyro_bias += e.segment<3>(Layout::kGyroBias);
  x.accel_bias += e.segment<3>(Layout::kAccelBias);
  x.gyro_scale += e.segment<3>(Layout::kGyroScale);
  x.accel_scale += e.segment<3>(Layout::kAccelScale);
  return x;
}

TEST(AlignmentProblem, InformationIsThatOfDifferences) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Random random(seed);
    const BodySignals body(shaken(100, 6, 100, seed));
    const ReferenceGrid grid(ReferenceIntegrals(shaken(98, 10, 200, seed + 100)), body.step);
    const FilteredPair pair{body, grid, 0.7, 1.3};
    ImuSensor sensor;
    sensor.gyro.scale = sensor.accel.scale = 0.1;
    std::vector<AlignmentEpoch> epochs;
    for (std::size_t k = 20; k + 20 < body.time.size(); k += 3) {
      // Sigmas so large that no residual is an outlier; some axes are not usable.
      epochs.push_back({k, {static_cast<std::uint8_t>(k % 7 == 0 ? 5 : 7), static_cast<std::uint8_t>(k % 5)}, 10, 30});
    }
    AlignmentState x;
    x.q_rb = random.rotation();
    x.first_knot = 100;
    x.knot_spacing = 6;
    x.gyro_drift.assign(2, Vector3d::Zero());
    x.accel_drift.assign(2, Vector3d::Zero());
    const auto information = solve_alignment(pair, epochs, sensor, x);

    Eigen::Matrix<double, Layout::kSize, Layout::kSize> expected = decltype(expected)::Zero();
    for (const AlignmentEpoch& e : epochs) {
      Eigen::Matrix<double, 6, Layout::kSize> J;
      for (int i = 0; i < Layout::kSize; ++i) {
        const double step = 1e-6;
        const AlignmentResidual up = residual(pair, moved(x, step * Vector20d::Unit(i)), e.sample),
                                down = residual(pair, moved(x, -step * Vector20d::Unit(i)), e.sample);
        J.col(i) << (up.gyro - down.gyro) / (2 * step), (up.accel - down.accel) / (2 * step);
      }
      for (int axis = 0; axis < 3; ++axis) {
        const double gyro = e.usable.gyro >> axis & 1 ? 1 / e.gyro_sigma : 0,
                     accel = e.usable.accel >> axis & 1 ? 1 / e.accel_sigma : 0;
        expected += gyro * gyro * J.row(axis).transpose() * J.row(axis);
        expected += accel * accel * J.row(3 + axis).transpose() * J.row(3 + axis);
      }
    }
    // The priors, which keep what is free in bounds.
    expected.diagonal().segment<3>(Layout::kGyroScale).array() += 100;
    expected.diagonal().segment<3>(Layout::kAccelScale).array() += 100;
    expected.diagonal().segment<3>(Layout::kLeverArm).array() += 0.01;
    expected.diagonal().segment<3>(Layout::kGyroBias).array() += 1;
    expected.diagonal().segment<3>(Layout::kAccelBias).array() += 0.01;
    const Vector20d unit = expected.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_LT((unit.asDiagonal() * (information - expected) * unit.asDiagonal()).cwiseAbs().maxCoeff(), 1e-6) << seed;
  }
}

TEST(AlignmentProblem, TheMomentOfALeverArmIsThatOfRigidMotion) {
  // The force at p, by differences: f + d(w × p)/dt + w × (w × p), mean over a cell.
  const auto imu = shaken(0, 3, 400, 9);
  const ReferenceIntegrals integrals(imu);
  const Vector3d p(0.3, -0.2, 0.5);
  const auto rate = [&](double t) -> Vector3d { return integrals.mean(t + 1e-4, 2e-4).gyro; };
  for (double t = 1; t < 2; t += 0.1) {
    const double interval = 0.02;
    constexpr int kParts = 200;
    Vector3d mean = (rate(t) - rate(t - interval)).cross(p) / interval;
    for (int i = 0; i < kParts; ++i) {
      const Vector3d w = rate(t - interval + interval * (i + 0.5) / kParts);
      mean += w.cross(w.cross(p)) / kParts;
    }
    EXPECT_LT((integrals.mean(t, interval).lever * p - mean).norm(), 2e-4 * (1 + mean.norm())) << t;
  }
}

TEST(RotationManifold, IsTheBoxplusOfTheProject) {
  const RotationManifold manifold;
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const Quaterniond q = random.rotation();
    const Vector3d phi = random.vector();
    Quaterniond moved_q;
    manifold.Plus(q.coeffs().data(), phi.data(), moved_q.coeffs().data());
    EXPECT_LT(moved_q.angularDistance(so3_exp(phi) * q), 1e-12);
    Vector3d back;
    manifold.Minus(moved_q.coeffs().data(), q.coeffs().data(), back.data());
    EXPECT_LT((back - so3_log(so3_exp(phi))).norm(), 1e-9);

    RotationManifold::RowJacobian43 plus, differences;
    manifold.PlusJacobian(q.coeffs().data(), plus.data());
    for (int k = 0; k < 3; ++k) {
      constexpr double kStep = 1e-6;
      differences.col(k) =
          ((so3_exp(kStep * Vector3d::Unit(k)) * q).coeffs() - (so3_exp(-kStep * Vector3d::Unit(k)) * q).coeffs()) /
          (2 * kStep);
    }
    EXPECT_LT((plus - differences).norm(), 1e-9);
    RotationManifold::RowJacobian34 minus;
    manifold.MinusJacobian(q.coeffs().data(), minus.data());
    EXPECT_LT((minus * plus - Matrix3d::Identity()).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace piste::test
