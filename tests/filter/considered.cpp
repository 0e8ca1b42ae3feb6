#include "filter/considered.h"

#include <gtest/gtest.h>

#include <vector>

#include "math/linear_algebra.h"
#include "support/random.h"

namespace piste {
namespace {

using Eigen::MatrixXd;
using test::Random;

FilterOptions with_stated_errors() {
  FilterOptions options;
  options.sensor.gyro = {.noise = 1e-3, .bias = 0.7, .drift = {}, .scale = 0.4};
  options.sensor.accel = {.noise = 1e-3, .bias = 0.5, .drift = {}, .scale = 0.3, .cross_axis = 0.2};
  return options;
}

TEST(Considered, IsWhatIsStatedAndNotEstimated) {
  FilterOptions options = with_stated_errors();
  options.estimate = {Block::kAccelBias, Block::kGyroScale, Block::kLeverArm};
  EXPECT_EQ(considered_blocks(options), (std::vector{Block::kGyroBias, Block::kAccelScale, Block::kAccelCrossAxis}));
  const StateLayout all = filter_layout(options), estimated(options.estimate);
  EXPECT_EQ(all.size(), estimated.size() + 9);
  Random random(3);
  const Covariance P = random.covariance(all.size()), part = restricted(P, all, estimated);
  EXPECT_TRUE(part.topLeftCorner(9, 9) == P.topLeftCorner(9, 9));
  const int a = all.offset(Block::kLeverArm), b = estimated.offset(Block::kLeverArm);
  EXPECT_TRUE((part.block<3, 3>(b, 0) == P.block<3, 3>(a, 0)));
  options.estimate = imu_error_blocks(options.sensor);
  EXPECT_TRUE(Considered(options, filter_layout(options)).none());
}

// Errors of a linear system as matrices on whitened unknowns: those of the start, of the steps and of the
// measurements. So the true covariance of every error is A Aᵀ, whatever filter or smoother say.
struct LinearRun {
  struct Instant {
    MatrixXd optimal, before;  // the error after the update by the whole gain, and before this update
    Covariance P_optimal, P_before;
    MatrixXd Phi;  // from this instant to the next
  };
  std::vector<Instant> instants;
  StateLayout layout;

  explicit LinearRun(int count) {
    FilterOptions options = with_stated_errors();
    options.estimate = {Block::kGyroScale, Block::kAccelBias};
    layout = filter_layout(options);
    const Considered considered(options, layout);
    const int n = layout.size(), first = layout.offset(Block::kGyroBias);
    Random random(11);
    Covariance P = Covariance::Zero(n, n);
    P.diagonal().setConstant(0.5);
    const int unknowns = n + count * (n + 3);
    MatrixXd A = MatrixXd::Zero(n, unknowns);
    A.leftCols(n) = P.diagonal().cwiseSqrt().asDiagonal();
    int next = n;
    for (int k = 0; k < count; ++k) {
      Linearization lin;
      lin.rows = 3;
      lin.covariance = 0.3 * Matrix3d::Identity();
      lin.residual = random.vector();
      lin.add(Block::kPosition, Matrix3d(random.matrix(3, 3)));
      lin.add(Block::kAttitude, Matrix3d(random.matrix(3, 3)));
      lin.add(Block::kGyroBias, Matrix3d(random.matrix(3, 3)));
      lin.add(Block::kAccelScale, Matrix3d(random.matrix(3, 3)));
      const Update u = innovate(P, layout, lin);
      Instant now{.optimal = {}, .before = A, .P_optimal = P, .P_before = P, .Phi = MatrixXd::Identity(n, n)};
      MatrixXd seen = u.H * A;
      seen.middleCols(next, 3) += std::sqrt(0.3) * MatrixXd::Identity(3, 3);
      next += 3;
      const MatrixXd K = gain(u);
      now.optimal = A - K * seen;
      update(now.P_optimal, u);
      considered.update(P, u);
      for (int i = 0; i < n; ++i) {
        ErrorVector row = K.row(i).norm() * ErrorVector::Ones(n);
        considered.hold(row);
        if (row(i) != 0) A.row(i) -= K.row(i) * seen;
      }
      EXPECT_LT((P - A * A.transpose()).cwiseAbs().maxCoeff(), 1e-12) << "instant " << k;
      EXPECT_TRUE((P.block<3, 3>(first, first).isApprox(0.5 * Matrix3d::Identity(), 1e-15)));

      now.Phi.topRows(9) += 0.2 * random.matrix(9, n);
      const MatrixXd noise = 0.2 * random.matrix(9, 9);
      P = (now.Phi * P * now.Phi.transpose()).eval();
      P.topLeftCorner(9, 9) += noise * noise.transpose();
      A = (now.Phi * A).eval();
      A.block(0, next, 9, 9) += noise;
      next += n;
      instants.push_back(now);
    }
  }
};

TEST(Considered, TheFilterHasTheCovarianceOfTheGainThatItUses) { LinearRun(12); }

// The claim of considered.h: with what is left out as noise, the smoother has the true covariance of its error.
TEST(Considered, TheSmootherHasTheCovarianceOfItsError) {
  const LinearRun run(12);
  MatrixXd A = run.instants.back().optimal;
  Covariance P = run.instants.back().P_optimal;
  for (std::size_t k = run.instants.size() - 1; k-- > 0;) {
    const LinearRun::Instant &now = run.instants[k], &after = run.instants[k + 1];
    const MatrixXd C = now.P_optimal * now.Phi.transpose() * inverse(MatrixXd(after.P_before));
    A = (now.optimal - C * (after.before - A)).eval();
    P = (now.P_optimal + C * (P - after.P_before) * C.transpose()).eval();
    const MatrixXd truth = A * A.transpose();
    EXPECT_LT((P - truth).cwiseAbs().maxCoeff(), 1e-10) << "instant " << k;
    EXPECT_LT(P.topLeftCorner(3, 3).trace(), now.P_optimal.topLeftCorner(3, 3).trace());
  }
}

}  // namespace
}  // namespace piste
