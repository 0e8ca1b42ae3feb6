#include "piste/filter/update.h"

#include <gtest/gtest.h>

#include "math/linear_algebra.h"
#include "support/blocks.h"
#include "support/random.h"

namespace piste {
namespace {

using Eigen::MatrixXd;
using test::Random;

double relative(const MatrixXd& a, const MatrixXd& b) { return (a - b).norm() / b.norm(); }

// A measurement of some blocks, one of which has a single state, and one six.
Linearization random_measurement(Random& random, int rows) {
  Linearization lin;
  lin.rows = rows;
  lin.residual = random.vector();
  lin.covariance = random.covariance(3);
  for (const Block b : {Block::kAttitude, Block::kPosition, Block::kGyroScale, Block::kGnssDelay, Block::kBoresight}) {
    lin.add(b, random.matrix(3, 3));
  }
  lin.add(Block::kGyroCrossAxis, random.matrix(3, kLargestBlock), 6);
  return lin;
}

class Rows : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  int rows() const { return std::get<0>(GetParam()); }
  StateLayout layout() const {
    return StateLayout(std::get<1>(GetParam()) ? test::most_blocks()
                                               : std::vector<Block>{Block::kGnssDelay, Block::kGyroScale});
  }
};

INSTANTIATE_TEST_SUITE_P(Kalman, Rows, testing::Combine(testing::Values(1, 2, 3), testing::Bool()));

TEST_P(Rows, UpdateIsTheDenseFormula) {
  Random random(1);
  const StateLayout l = layout();
  const int n = l.size(), m = rows();
  for (int i = 0; i < 10; ++i) {
    const Linearization lin = random_measurement(random, m);
    const Covariance P = random.covariance(n);
    const Update u = innovate(P, l, lin);

    MatrixXd H = MatrixXd::Zero(m, n);
    for (int k = 0; k < lin.count(); ++k) {
      const Linearization::Term& term = lin.term(k);
      if (!l.has(term.block)) continue;
      H.middleCols(l.offset(term.block) + term.column, term.size()) = term.jacobian.topLeftCorner(m, term.size());
    }
    const MatrixXd R = lin.covariance.topLeftCorner(m, m), S = H * P * H.transpose() + R;
    const MatrixXd K = P * H.transpose() * inverse(S), A = MatrixXd::Identity(n, n) - K * H;
    const Eigen::VectorXd z = lin.residual.head(m);
    EXPECT_TRUE(u.H.topRows(m) == H);
    EXPECT_TRUE(u.H.bottomRows(3 - m).isZero(0));
    EXPECT_LT(relative(u.S.topLeftCorner(m, m), S), 1e-14);
    EXPECT_NEAR(u.nis / z.dot(inverse(S) * z), 1, 1e-12);
    EXPECT_LT(relative(gain(u).leftCols(m), K), 1e-13);
    EXPECT_TRUE(gain(u).rightCols(3 - m).isZero(0));
    EXPECT_TRUE(u.residual.tail(3 - m).isZero(0));

    Covariance joined = P;
    update(joined, u);
    EXPECT_LT(relative(joined, A * P * A.transpose() + K * R * K.transpose()), 1e-13);
    EXPECT_TRUE(joined == joined.transpose());
  }
}

// The form must bear a measurement far better than the prior.
TEST(Kalman, JosephStaysPositiveWithAnAlmostPerfectMeasurement) {
  Random random(2);
  const StateLayout layout;
  Covariance P = 1e6 * random.covariance(9);
  Linearization lin;
  lin.covariance = 1e-8 * Matrix3d::Identity();
  lin.add(Block::kPosition, Matrix3d::Identity());
  for (int i = 0; i < 20; ++i) {
    const Update u = innovate(P, layout, lin);
    update(P, u);
    EXPECT_GT(P.diagonal().minCoeff(), 0);
  }
  EXPECT_NEAR(P(0, 0), 1e-8 / 20, 1e-11);
}

ResetJacobian some_reset(Random& random) {
  FullError correction = FullError::Zero();
  for (const Block b : {Block::kVelocity, Block::kAttitude, Block::kBoresight}) {
    correction.segment<3>(full_offset(b)) = random.vector(0.2);
  }
  ResetJacobian G = reset_jacobian(correction);
  G.position_attitude = random.matrix(3, 3);
  G.position_lever_arm = random.matrix(3, 3);
  return G;
}

MatrixXd dense(const ResetJacobian& G, const StateLayout& layout) {
  MatrixXd full = MatrixXd::Identity(layout.size(), layout.size());
  full.block<6, 6>(layout.offset(Block::kVelocity), layout.offset(Block::kVelocity)) = G.velocity_attitude;
  for (std::size_t i = 0; i < kMountingBlocks.size(); ++i) {
    const int o = layout.offset(kMountingBlocks[i]);
    if (o >= 0) full.block<3, 3>(o, o) = G.mountings[i];
  }
  full.block<3, 3>(0, layout.offset(Block::kAttitude)) = G.position_attitude;
  if (const int o = layout.offset(Block::kLeverArm); o >= 0) full.block<3, 3>(0, o) = G.position_lever_arm;
  return full;
}

TEST_P(Rows, ResetIsTheDenseProduct) {
  Random random(3);
  const StateLayout l = layout();
  const ResetJacobian G = some_reset(random);
  const MatrixXd D = dense(G, l);
  const Covariance P = random.covariance(l.size());
  Covariance turned = P;
  reset(turned, l, G);
  EXPECT_LT(relative(turned, D * P * D.transpose()), 1e-14);

  Covariance Lambda = P;
  ErrorVector lambda = random.matrix(l.size(), 1);
  const MatrixXd expected = D.transpose() * lambda;
  reset_adjoint(lambda, Lambda, l, G);
  EXPECT_LT(relative(Lambda, D.transpose() * P * D), 1e-14);
  MatrixXd columns = random.matrix(l.size(), 6);
  const MatrixXd expected_columns = D.transpose() * columns;
  reset_adjoint(columns, l, G);
  EXPECT_LT(relative(columns, expected_columns), 1e-14);
  EXPECT_LT(relative(lambda, expected), 1e-14);
  ErrorVector error = random.matrix(l.size(), 1);
  const MatrixXd expected_error = D * error;
  reset_error(error, l, G);
  EXPECT_LT(relative(error, expected_error), 1e-14);
}

TEST_P(Rows, UpdateAdjointIsTheDenseFormula) {
  Random random(4);
  const StateLayout l = layout();
  const int n = l.size();
  const Update u = innovate(random.covariance(n), l, random_measurement(random, rows()));
  const MatrixXd A = MatrixXd::Identity(n, n) - gain(u) * u.H;
  const MatrixXd H = u.H.topRows(rows()), weight = inverse(u.S.topLeftCorner(rows(), rows()));
  Covariance Lambda = random.covariance(n);
  ErrorVector lambda = random.matrix(n, 1);
  const MatrixXd expected_lambda = A.transpose() * lambda - H.transpose() * weight * u.residual.head(rows());
  const MatrixXd expected_Lambda = A.transpose() * Lambda * A + H.transpose() * weight * H;
  update_adjoint(lambda, Lambda, u);
  EXPECT_LT(relative(lambda, expected_lambda), 1e-13);
  EXPECT_LT(relative(Lambda, expected_Lambda), 1e-13);
  MatrixXd columns = random.matrix(n, 6);
  const MatrixXd expected_columns = A.transpose() * columns;
  update_adjoint(columns, u);
  EXPECT_LT(relative(columns, expected_columns), 1e-13);
  EXPECT_TRUE(Lambda == Lambda.transpose());
}

// An error e about x is G (e − correction) about x ⊞ correction, for e near a large correction.
// The first fix after a long outage, 67 m against 1 cm: what is smoothed stands the same before it and after it.
TEST(Kalman, SmoothedCovarianceSurvivesAnOutage) {
  Random random(7);
  const StateLayout l{};
  const int n = l.size();
  for (int i = 0; i < 20; ++i) {
    // Velocity and attitude that were not known well have run into the position for a minute.
    MatrixXd drift = MatrixXd::Identity(n, n);
    drift.block<3, 3>(0, 3) = 60 * Eigen::Matrix3d::Identity();
    drift.block<3, 3>(0, 6) = 30000 * random.matrix(3, 3);
    MatrixXd known = 1e-4 * random.covariance(n);
    known.bottomRightCorner(3, 3) *= 0.1;
    const Covariance before = drift * known * drift.transpose();

    Linearization lin;
    lin.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    lin.add(Block::kPosition, Eigen::Matrix3d::Identity());
    lin.add(Block::kAttitude, 0.4 * random.matrix(3, 3));
    const Update u = innovate(before, l, lin);
    Covariance after = before;
    update(after, u);
    // What later fixes tell: Λ = (P + N)⁻¹, where they leave N of the errors.
    const MatrixXd later = inverse(after + 1e-4 * random.covariance(n));
    Covariance Lambda = 0.5 * (later + later.transpose());
    const MatrixXd smoothed_after = after - after * Lambda * after;
    ErrorVector lambda = ErrorVector::Zero(n);
    // Of the error before the fix, with what was measured left out: λ without its residual.
    MatrixXd column = random.matrix(n, 1);
    Update unmoved = u;
    unmoved.residual.setZero();
    ErrorVector same = column;
    Covariance ignored = Lambda;
    update_adjoint(column, u);
    update_adjoint(same, ignored, unmoved);
    EXPECT_LT(relative(column, same), 1e-13);
    update_adjoint(lambda, Lambda, u);
    const MatrixXd smoothed_before = before - before * Lambda * before;
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(before(k, k), 100);
      EXPECT_NEAR(smoothed_before(k, k) / smoothed_after(k, k), 1, 0.05) << "trial " << i << " axis " << k;
    }
  }
}

TEST(Kalman, ResetJacobianIsTheDifferenceOfErrors) {
  Random random(5);
  for (int i = 0; i < 10; ++i) {
    const Estimate x = random.estimate();
    FullError correction;
    for (int k = 0; k < kFullSize; ++k) correction(k) = random.gaussian(0.2);
    const Estimate corrected = boxplus(x, correction);
    const ResetJacobian G = reset_jacobian(correction);
    const StateLayout everything(test::most_blocks());
    const MatrixXd claimed = dense(G, everything);
    const Eigen::Index n = claimed.rows();  // the blocks of a run are the first ones
    MatrixXd numeric(n, n);
    constexpr double h = 1e-4;
    for (Eigen::Index k = 0; k < n; ++k) {
      const FullError e = h * FullError::Unit(k);
      const FullError moved =
          boxminus(boxplus(x, correction + e), corrected) - boxminus(boxplus(x, correction - e), corrected);
      numeric.col(k) = moved.head(n) / (2 * h);
    }
    EXPECT_LT((claimed - numeric).cwiseAbs().maxCoeff(), 1e-7);
  }
}

}  // namespace
}  // namespace piste
