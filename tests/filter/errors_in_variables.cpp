// The false score of the scales: against the exact mean in linear problems, at rest, and with a bias.

#include "filter/errors_in_variables.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "model/imu_errors.h"
#include "piste/filter/update.h"
#include "piste/math/so3.h"
#include "piste/math/statistics.h"
#include "support/random.h"

namespace piste {
namespace {

FilterOptions options_with(std::vector<Block> estimate) {
  FilterOptions options;
  options.sensor.gyro.noise = 2e-3;
  options.sensor.accel.noise = 3e-3;
  options.estimate = std::move(estimate);
  return options;
}

const std::vector<Block> kAll{Block::kGyroBias, Block::kGyroScale, Block::kAccelScale};

const Vector3d kNoGravity = Vector3d::Zero();

Covariance known(const StateLayout& layout, double attitude, double velocity) {
  Covariance P = Covariance::Identity(layout.size(), layout.size());
  P.diagonal().segment<3>(layout.offset(Block::kAttitude)).setConstant(attitude);
  P.diagonal().segment<3>(layout.offset(Block::kVelocity)).setConstant(velocity);
  return P;
}

// A fix of one block with that variance.
Linearization fix_of(Block block, double variance) {
  Linearization lin;
  lin.observes = block;
  lin.add(block, Matrix3d::Identity());
  lin.covariance.diagonal().setConstant(variance);
  return lin;
}

// An instant with a fix of attitude and one of velocity. P is as before it in the end.
void observe_both(ErrorsInVariables& of, const StateLayout& layout, const Estimate& x, const Covariance& P,
                  double attitude, double velocity) {
  for (const Linearization& lin : {fix_of(Block::kAttitude, attitude), fix_of(Block::kVelocity, velocity)})
    of.observe(x, P, kNoGravity, innovate(P, layout, lin), lin);
}

// The result of such fixes kEvery apart, when it no longer changes. Each takes the variances of attitude and velocity
// to a quarter.
FalseInformation settled(const FilterOptions& options, const Covariance& before, const Estimate& x = {}) {
  const StateLayout layout(options.estimate);
  ErrorsInVariables of(options, layout);
  FalseInformation last{};
  const double attitude = before(6, 6), velocity = before(3, 3);
  for (int i = 0; i < 200; ++i) {
    of.add(0.6 * ErrorsInVariables::kEvery);
    of.add(0.4 * ErrorsInVariables::kEvery);
    observe_both(of, layout, x, before, attitude / 3, velocity / 3);
    last = of.after_fixes(x).value();
    EXPECT_FALSE(of.after_fixes(x));
  }
  return last;
}

// The score of fixes of a known variance before and after is q T / (P₋ + P₊), by the sum of the recursion.
TEST(ErrorsInVariables, IsTheNoiseOverTheVariancesBeforeAndAfter) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  const auto [score, information] = settled(options, known(layout, 4e-4, 9e-4));
  EXPECT_NEAR(score(0), 4e-6 * ErrorsInVariables::kEvery / 5e-4, 1e-12);
  EXPECT_NEAR(score(2), score(0), 1e-12);
  EXPECT_NEAR(score(4), 9e-6 * ErrorsInVariables::kEvery / (9e-4 * 1.25), 1e-12);
  EXPECT_LT((information - score).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(ErrorsInVariables, WaitsUntilItIsDue) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  ErrorsInVariables of(options, layout);
  double sum = 0, every = 0;
  for (int i = 1; i <= 12; ++i) {
    of.add(0.35 * ErrorsInVariables::kEvery);
    observe_both(of, layout, {}, known(layout, 4e-4, 9e-4), 1e-4, 1e-4);
    const auto now = of.after_fixes({});
    EXPECT_EQ(now.has_value(), i % 3 == 0);
    if (now) sum += now->score(0);
  }
  ErrorsInVariables each(options, layout);
  for (int i = 1; i <= 12; ++i) {
    each.add(0.35 * ErrorsInVariables::kEvery);
    observe_both(each, layout, {}, known(layout, 4e-4, 9e-4), 1e-4, 1e-4);
    if (const auto now = each.after_fixes({})) every += now->score(0);
  }
  EXPECT_EQ(sum, every);
  EXPECT_GT(sum, 0);
}

// At rest fixes observe the noise of the motion before, until nothing is left of it. Fixes of a long rest that come
// after that change nothing.
TEST(ErrorsInVariables, FixesAtRestCountUntilTheNoiseIsObserved) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  const auto with = [&](int at_rest) {
    ErrorsInVariables of(options, layout);
    Covariance P = known(layout, 4e-6 * 60, 9e-6 * 60);
    of.add(60);
    for (int k = 0; k < at_rest; ++k) {
      for (const Linearization& lin : {fix_of(Block::kAttitude, 1e-4), fix_of(Block::kVelocity, 1e-4)}) {
        const Update u = innovate(P, layout, lin);
        of.observe({}, P, kNoGravity, u, lin);
        update(P, u);
      }
      of.after_fixes({});
    }
    of.add(ErrorsInVariables::kEvery);
    const Linearization lin = fix_of(Block::kPosition, 1e-6);
    of.observe({}, P, kNoGravity, innovate(P, layout, lin), lin);
    return of.after_fixes({}).value().information;
  };
  // The body stands where the fixes have it: the noise of before is no longer in its position.
  EXPECT_LT(with(200).maxCoeff(), 1.001);
  EXPECT_LT((with(2000) - with(200)).cwiseAbs().maxCoeff(), 1e-3);
}

// After an outage the first fixes come at rest, where many of them determine the place. What the noise of the outage
// made of the position is gone with them.
TEST(ErrorsInVariables, AnOutageThatEndsAtRestIsOver) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  ErrorsInVariables of(options, layout);
  Covariance P = known(layout, 4e-6 * 60, 9e-6 * 60);
  P.topLeftCorner<3, 3>() *= 100;
  const auto fix = [&](Block block, double variance) {
    const Linearization lin = fix_of(block, variance);
    const Update u = innovate(P, layout, lin);
    of.observe({}, P, kNoGravity, u, lin);
    update(P, u);
  };
  of.add(60);
  fix(Block::kVelocity, 1e-4);  // it stops before the receiver is back
  of.after_fixes({});
  for (int k = 0; k < 40; ++k) {
    fix(Block::kPosition, 1e-4);
    fix(Block::kVelocity, 1e-4);
    of.after_fixes({});
  }
  of.add(1);
  fix(Block::kPosition, 1e-4);
  EXPECT_LT(of.after_fixes({}).value().score.cwiseAbs().maxCoeff(), 1);  // some 300 with what is gone
}

// The noise explains no more than all of the error: the trace is at most the rows of the fix, whatever the covariance.
TEST(ErrorsInVariables, StaysBoundedAfterAnOutage) {
  FilterOptions options = options_with({Block::kGyroDrift, Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale});
  options.sensor.gyro.drift = options.sensor.accel.drift = {DriftProcess::Kind::kGaussMarkov, 1e-3, 60, 0};
  const StateLayout layout(options.estimate);
  ErrorsInVariables of(options, layout);
  of.add(600);
  Covariance P = known(layout, square(options.sensor.gyro.noise) * 600, square(options.sensor.accel.noise) * 600);
  const Linearization lin = fix_of(Block::kAttitude, 1e-12);
  of.observe({}, P, kNoGravity, innovate(P, layout, lin), lin);
  const ScaleScore score = of.after_fixes({}).value().information;
  EXPECT_LT(score.maxCoeff(), 1.001);
  EXPECT_GT(score(0), 0.999);
}

// The rate that turns the attitude is the measured one over 1 + s, and its derivative by s has this squared.
TEST(ErrorsInVariables, IsThatOfTheEstimatedScale) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  const auto of_scale = [&](const Vector3d& scale) {
    Estimate x;
    x.gyro_scale = x.accel_scale = scale;
    return settled(options, known(layout, 4e-4, 9e-4), x);
  };
  const FalseInformation scaled = of_scale({0.1, 0, -0.1}), without = of_scale({0, 0, 0});
  const ScaleScore ratio = scaled.score.cwiseQuotient(without.score);
  EXPECT_NEAR(ratio(0), 1 / 1.331, 1e-12);
  EXPECT_NEAR(ratio(1), 1, 1e-12);
  EXPECT_NEAR(ratio(5), 1 / 0.729, 1e-12);
  EXPECT_NEAR(scaled.information(0) / without.information(0), 1 / 1.4641, 1e-12);
}

// The exact mean is the trace of Hᵀ S⁻¹ H N over all fixes, N being the covariance of what this noise alone has made of
// the errors.
TEST(ErrorsInVariables, IsExactHoweverTheNoiseIsSeen) {
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  constexpr double kStep = 0.01, kOfPosition = 0.01, kOfVelocity = 0.03;
  const Vector3d gravity(0, 0, 9.8);
  const FilterOptions options = options_with({Block::kGyroScale, Block::kAccelScale});
  const StateLayout layout(options.estimate);
  Matrix9d Phi = Matrix9d::Identity();
  Phi.block<3, 3>(0, 3).diagonal().setConstant(kStep);
  Phi.block<3, 3>(3, 6) = kStep * skew(gravity);
  for (const int every : {10, 100}) {
    for (const bool positions : {false, true}) {
      for (const bool velocities : {false, true}) {
        if (!positions && !velocities) continue;
        Eigen::MatrixXd H(0, 9);
        std::vector<double> variances;
        const auto measure = [&](int state, double sigma) {
          H.conservativeResize(H.rows() + 3, 9);
          H.bottomRows(3).setZero();
          H.bottomRows(3).middleCols(state, 3).setIdentity();
          variances.insert(variances.end(), 3, sigma * sigma);
        };
        if (positions) measure(0, kOfPosition);
        if (velocities) measure(3, kOfVelocity);
        const Eigen::MatrixXd noise_of_fix = Eigen::Map<Eigen::VectorXd>(variances.data(), H.rows()).asDiagonal();
        Covariance P = Covariance::Identity(layout.size(), layout.size());
        P.topLeftCorner<9, 9>() *= 1e-4;
        std::array<Matrix9d, 2> made;  // by the noise of one axis: gyroscope, accelerometer
        made.fill(Matrix9d::Zero());
        std::array<double, 2> exact{}, summed{};
        ErrorsInVariables of(options, layout);
        for (int i = 1; i <= 30000; ++i) {
          const std::array<double, 2> density{std::pow(options.sensor.gyro.noise, 2) * kStep,
                                              std::pow(options.sensor.accel.noise, 2) * kStep};
          Matrix9d nav = Phi * P.topLeftCorner<9, 9>() * Phi.transpose();
          for (int k = 0; k < 2; ++k) {
            nav.diagonal().segment<3>(k == 0 ? 6 : 3).array() += density[static_cast<std::size_t>(k)];
            Matrix9d& N = made[static_cast<std::size_t>(k)];
            N = (Phi * N * Phi.transpose()).eval();
            N(k == 0 ? 6 : 3, k == 0 ? 6 : 3) += density[static_cast<std::size_t>(k)];
          }
          P.topLeftCorner<9, 9>() = nav;
          of.add(kStep);
          if (i % every != 0) continue;
          Covariance before = P;
          for (const auto& [seen, block, sigma] : {std::tuple(positions, Block::kPosition, kOfPosition),
                                                   std::tuple(velocities, Block::kVelocity, kOfVelocity)}) {
            if (!seen) continue;
            const Linearization lin = fix_of(block, sigma * sigma);
            const Update u = innovate(before, layout, lin);
            of.observe({}, before, gravity, u, lin);
            update(before, u);
          }
          const Eigen::MatrixXd S_inverse = (H * nav * H.transpose() + noise_of_fix).inverse();
          const Matrix9d information = H.transpose() * S_inverse * H, keep = Matrix9d::Identity() - nav * information;
          P.topLeftCorner<9, 9>() = keep * nav;
          const bool settled = i > 10000;
          for (std::size_t k = 0; k < 2; ++k) {
            if (settled) exact[k] += (information * made[k]).trace();
            made[k] = (keep * made[k] * keep.transpose()).eval();
          }
          const auto now = of.after_fixes({});
          if (now && settled) summed = {summed[0] + now->score(0), summed[1] + now->score(3)};
        }
        EXPECT_NEAR(summed[0] / exact[0], 1, 0.01) << every << positions << velocities;
        EXPECT_NEAR(summed[1] / exact[1], 1, 0.01) << every << positions << velocities;
      }
    }
  }
}

// What is not known of the drifts is in the rates, too, and a drift hides some of what the noise does. The errors of
// navigation and drifts, and their derivative by a scale as the measured rate has it, go through every step and fix;
// their covariance says what the fixes tell.
TEST(ErrorsInVariables, IsExactWithDrifts) {
  constexpr double kStep = 0.01, kOfPosition = 0.02, kOfVelocity = 0.04;
  constexpr int kEvery = 10, kSettled = 30000, kSteps = 40000, kDrifts = 15;
  const Vector3d gravity(0, 0, 9.8);
  FilterOptions options = options_with({Block::kGyroDrift, Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale});
  options.sensor.gyro.drift = {DriftProcess::Kind::kGaussMarkov, 1e-3, 60, 0};
  options.sensor.accel.drift = {DriftProcess::Kind::kGaussMarkov, 2e-2, 40, 0};
  const StateLayout layout(options.estimate);
  ASSERT_EQ(layout.offset(Block::kAccelDrift), 12);
  Eigen::MatrixXd Phi = Eigen::MatrixXd::Identity(kDrifts, kDrifts);
  Phi.block<3, 3>(0, 3).diagonal().setConstant(kStep);
  Phi.block<3, 3>(3, 6) = kStep * skew(gravity);
  Phi.block<3, 3>(6, 9).diagonal().setConstant(-kStep);
  Phi.block<3, 3>(3, 12).diagonal().setConstant(-kStep);
  Eigen::VectorXd noise = Eigen::VectorXd::Zero(kDrifts);
  noise.segment<3>(6).setConstant(square(options.sensor.gyro.noise) * kStep);
  noise.segment<3>(3).setConstant(square(options.sensor.accel.noise) * kStep);
  for (int k = 9; k < kDrifts; ++k) {
    const DiscreteProcess d = discretise(k < 12 ? options.sensor.gyro.drift : options.sensor.accel.drift, kStep);
    Phi(k, k) = d.transition;
    noise(k) = d.variance;
  }
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6, kDrifts);
  H.leftCols<6>().setIdentity();
  Eigen::VectorXd of_fix(6);
  of_fix << Vector3d::Constant(square(kOfPosition)), Vector3d::Constant(square(kOfVelocity));
  Covariance P = Covariance::Identity(layout.size(), layout.size());
  P.topLeftCorner(kDrifts, kDrifts) *= 1e-4;
  const std::array<int, 4> turned{6, 7, 3, 5}, drifts{9, 10, 12, 14}, scales{0, 1, 3, 5};
  std::array<Eigen::MatrixXd, 4> both;  // E[error derivativeᵀ], by the scale of an axis
  both.fill(Eigen::MatrixXd::Zero(kDrifts, kDrifts));
  std::array<double, 4> exact{}, summed{};
  ErrorsInVariables of(options, layout);
  for (int i = 1; i <= kSteps; ++i) {
    const Eigen::MatrixXd before = P.topLeftCorner(kDrifts, kDrifts);
    Eigen::MatrixXd Q = Phi * before * Phi.transpose();
    Q.diagonal() += noise;
    for (std::size_t k = 0; k < 4; ++k) {
      both[k] = (Phi * both[k] * Phi.transpose()).eval();
      both[k](turned[k], turned[k]) += noise(turned[k]);
      both[k].col(turned[k]) -= kStep * Phi * before.col(drifts[k]);
    }
    of.add(kStep);
    P.topLeftCorner(kDrifts, kDrifts) = Q;
    if (i % kEvery != 0) continue;
    Covariance until = P;
    for (const auto& [block, sigma] :
         {std::pair(Block::kPosition, kOfPosition), std::pair(Block::kVelocity, kOfVelocity)}) {
      const Linearization lin = fix_of(block, sigma * sigma);
      const Update u = innovate(until, layout, lin);
      of.observe({}, until, gravity, u, lin);
      update(until, u);
    }
    const Eigen::MatrixXd S = H * Q * H.transpose() + Eigen::MatrixXd(of_fix.asDiagonal());
    const Eigen::MatrixXd information = H.transpose() * S.inverse() * H;
    const Eigen::MatrixXd keep = Eigen::MatrixXd::Identity(kDrifts, kDrifts) - Q * information;
    P.topLeftCorner(kDrifts, kDrifts) = keep * Q;
    const auto now = of.after_fixes({});
    for (std::size_t k = 0; k < 4; ++k) {
      if (i > kSettled) exact[k] += (information * both[k]).trace();
      if (i > kSettled && now) summed[k] += now->score(scales[k]);
      both[k] = (keep * both[k] * keep.transpose()).eval();
    }
  }
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(summed[k] / exact[k], 1, 0.03) << k;
}

// Fixes of an antenna above a body that is held up against gravity. Columns: errors at the start, then every sample's
// noise of the gyroscope to the right. They are its effect on the errors, and on their derivative by the scale as the
// measured rate has it. `exact` sums the false score of the fixes so, and `summed` that of the recursion.
struct Swinging {
  static constexpr double kStep = 0.01, kOfPosition = 0.01, kOfVelocity = 0.03, kTold = 0.6;
  static constexpr int kEvery = 10, kSteps = 990, kCounted = 270, kAxis = 1;  // whole scores, of nine fixes each

  // `swing`: whether the velocities hold the noise. They are taken to be as uncertain in any case.
  explicit Swinging(bool swing) {
    FilterOptions options = options_with({Block::kGyroScale});
    const StateLayout layout(options.estimate);
    ErrorsInVariables of(options, layout), smoothed(options, layout);
    const Vector3d gravity(0, 0, 9.8);
    const Matrix3d M = skew(Vector3d(0, 0, 0.4));
    const double noise = options.sensor.gyro.noise / std::sqrt(kStep);
    Eigen::Matrix<double, 9, 9> Phi = Eigen::Matrix<double, 9, 9>::Identity();
    Phi.block<3, 3>(0, 3).diagonal().setConstant(kStep);
    Phi.block<3, 3>(3, 6) = kStep * skew(gravity);
    Covariance P = Covariance::Identity(layout.size(), layout.size());
    P.topLeftCorner<9, 9>() *= 1e-4;
    Eigen::MatrixXd free = Eigen::MatrixXd::Zero(9, 9 + kSteps);  // the error without fixes
    free.leftCols(9).diagonal().setConstant(0.01);
    Eigen::MatrixXd error = free, derivative = free;  // with them
    for (int k = 0; k < kSteps; ++k) {
      for (Eigen::MatrixXd* r : {&free, &error, &derivative}) {
        *r = (Phi * *r).eval();
        (*r)(6 + kAxis, 9 + k) -= noise * kStep;
      }
      P.topLeftCorner<9, 9>() = (Phi * P.topLeftCorner<9, 9>() * Phi.transpose()).eval();
      P.diagonal().segment<3>(6).array() += noise * noise * kStep * kStep;
      of.add(kStep);
      smoothed.add_smoothed(kStep);
      if (k % kEvery != kEvery - 1 || k + 1 == kSteps) continue;
      const bool counts = k >= kCounted && k < kSteps - kCounted;
      for (const bool velocity : {false, true}) {
        Linearization lin;
        lin.add(velocity ? Block::kVelocity : Block::kPosition, Matrix3d::Identity());
        lin.covariance.diagonal().setConstant(square(velocity ? kOfVelocity : kOfPosition));
        if (velocity) lin.covariance += noise * noise * M * M.transpose();
        Eigen::MatrixXd held = Eigen::MatrixXd::Zero(3, 9 + kSteps), in_jacobian = held;
        if (velocity && swing) {
          lin.by_rate_noise = M;
          lin.observed_noise = kTold;
          held.col(9 + k) = -noise * M.col(kAxis);
          for (const int beside : {8 + k, 10 + k}) in_jacobian.col(beside) = -0.5 * kTold * noise * M.col(kAxis);
        }
        const Update u = innovate(P, layout, lin);
        of.observe({}, P, gravity, u, lin);
        smoothed.observe({}, P, gravity, u, lin, 1, true);
        const Eigen::Matrix<double, 3, 9> H = u.H.leftCols<9>();
        const Eigen::MatrixXd of_error = H * error + held, of_derivative = H * derivative + in_jacobian;
        if (counts) exact += of_derivative.cwiseProduct(u.S_inverse * of_error).rightCols(kSteps).sum();
        if (counts) seeming += square_in(u.S_inverse, of_derivative) - square_in(u.S_inverse, in_jacobian);
        error -= gain(u).topRows<9>() * of_error;
        derivative -= gain(u).topRows<9>() * of_derivative;
        rows.push_back({H * free, held, in_jacobian, lin.covariance, counts});
        update(P, u);
      }
      const auto about_smoothed = smoothed.after_fixes({});
      if (about_smoothed && counts) smoothed_summed += about_smoothed->score(kAxis);
      const auto now = of.after_fixes({});
      if (now && counts) summed += now->score(kAxis);
      if (now && counts) information += now->information(kAxis);
    }
  }

  // tr(Cᵀ W C) of the columns of the noise.
  static double square_in(const Matrix3d& W, const Eigen::MatrixXd& C) {
    return C.cwiseProduct(W * C).rightCols(kSteps).sum();
  }

  // The exact mean of the score about a smoothed run. Its rates are without the noise as the smoother finds it, which
  // takes the noise of the fixes for independent; its residuals likewise.
  double exact_smoothed() const {
    const auto n = static_cast<Eigen::Index>(3 * rows.size());
    Eigen::MatrixXd H(n, 9 + kSteps), held = H;
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      H.middleRows<3>(at) = rows[i].free;
      held.middleRows<3>(at) = rows[i].held;
      R.block<3, 3>(at, at) = rows[i].covariance;
    }
    const Eigen::MatrixXd S = H * H.transpose() + R, K = S.ldlt().solve(H).transpose();
    const Eigen::MatrixXd with = K * (H + held);  // E[û uᵀ]
    const Eigen::MatrixXd added = H * held.transpose();
    const Eigen::MatrixXd all = K * (S + added + added.transpose()) * K.transpose();  // E[û ûᵀ]; R has the rest
    const Eigen::MatrixXd residual = (H + held) - H * with;                           // E[(z − H û) uᵀ]
    double sum = 0;
    for (int k = kCounted; k < kSteps - kCounted; ++k) sum += with(9 + k, 9 + k) - all(9 + k, 9 + k);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!rows[i].counts) continue;
      const auto at = static_cast<Eigen::Index>(3 * i);
      const Matrix3d weight = rows[i].covariance.inverse();
      sum += rows[i].in_jacobian.cwiseProduct(weight * residual.middleRows<3>(at)).sum();
    }
    return sum;
  }

  struct Row {
    Eigen::MatrixXd free, held, in_jacobian;
    Matrix3d covariance;
    bool counts;
  };
  std::vector<Row> rows;
  double exact = 0, summed = 0, smoothed_summed = 0;
  // The false information on the scale. That of the rate in a Jacobian counts where the noise in
  // the attitude meets it; its own square is not here, as for it this rate is shrunk (beyond_noise()).
  double seeming = 0, information = 0;
};

TEST(ErrorsInVariables, IsExactWhereAVelocityHoldsTheSameNoise) {
  const Swinging with(true), without(false);
  EXPECT_NEAR((with.summed - without.summed) / (with.exact - without.exact), 1, 0.05);
  EXPECT_LT(with.exact, without.exact);
  EXPECT_NEAR(without.summed / without.exact, 1, 0.01);
  EXPECT_NEAR(without.information / without.seeming, 1, 0.02);
  EXPECT_NEAR(with.information / with.seeming, 1, 0.05);
  EXPECT_EQ(without.smoothed_summed, 0);
  EXPECT_NEAR(without.exact_smoothed(), 0, 1e-3 * without.exact);
  EXPECT_NEAR(with.smoothed_summed / with.exact_smoothed(), 1, 0.3);  // one half, in place of 0.50 to 0.66
}

TEST(ErrorsInVariables, ATiltThatABiasExplainsIsNotTheNoise) {
  const FilterOptions options = options_with(kAll);
  const StateLayout layout(options.estimate);
  const Covariance P = known(layout, 1e-4, 1);
  Covariance hidden = P;
  // The attitude's error is that of the bias, and 1e-4 more.
  const int a = layout.offset(Block::kAttitude), b = layout.offset(Block::kGyroBias);
  for (int k = 0; k < 3; ++k) {
    hidden(a + k, a + k) += 0.25;
    hidden(a + k, b + k) = hidden(b + k, a + k) = 0.5;
  }
  const auto score_of = [&](const Covariance& before) {
    ErrorsInVariables of(options, layout);
    of.add(1);
    observe_both(of, layout, {}, before, 1e-4, 1);
    return of.after_fixes({}).value().score;
  };
  EXPECT_LT((score_of(hidden) - score_of(P)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ErrorsInVariables, SaysNothingAtRestNorOfScalesThatAreCorrectedOrKnown) {
  const StateLayout layout(kAll);
  ErrorsInVariables at_rest(options_with(kAll), layout);
  observe_both(at_rest, layout, {}, known(layout, 1e-4, 1e-4), 1e-4, 1e-4);
  EXPECT_FALSE(at_rest.after_fixes({}));

  FilterOptions corrected = options_with(kAll);
  corrected.attitude.resize(1);
  ErrorsInVariables with_reference(corrected, layout);
  with_reference.add(ErrorsInVariables::kEvery);
  observe_both(with_reference, layout, {}, known(layout, 4e-4, 4e-4), 1e-4, 1e-4);
  const auto of_noise = with_reference.after_fixes({});
  ASSERT_TRUE(of_noise);
  EXPECT_EQ(of_noise->score.head<3>(), Vector3d::Zero());
  EXPECT_EQ(of_noise->information.head<3>(), Vector3d::Zero());
  EXPECT_GT(of_noise->score.tail<3>().minCoeff(), 0);

  const StateLayout bias(std::vector<Block>{Block::kGyroBias});
  ErrorsInVariables without_scales(options_with({Block::kGyroBias}), bias);
  without_scales.add(ErrorsInVariables::kEvery);
  observe_both(without_scales, bias, {}, known(bias, 1e-4, 1e-4), 1e-4, 1e-4);
  EXPECT_FALSE(without_scales.after_fixes({}));
}

// The attitude about each axis, measured once a second, determines the scale of a slow swing, and noise feigns a fifth
// of that information. Returns the mean of the scale's squared error by its variance.
double mean_of_squares(bool removes) {
  constexpr int kRuns = 100, kSteps = 4000, kEvery = 4;
  constexpr double kStep = 0.25, kOfFix = 0.02, kSwing = 0.05, kScale = 0.1;
  FilterOptions options = options_with({Block::kGyroScale});
  options.sensor.gyro.noise = 0.02;
  const StateLayout layout(options.estimate);
  const int a = layout.offset(Block::kAttitude), s = layout.offset(Block::kGyroScale);
  test::Random random(12);
  double sum = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Vector3d scale = random.vector(kScale);
    Covariance P = Covariance::Zero(layout.size(), layout.size());
    P.diagonal().head<6>().setConstant(1e-12);
    P.diagonal().segment<3>(a).setConstant(square(kOfFix));
    P.diagonal().segment<3>(s).setConstant(square(kScale));
    ErrorVector error = ErrorVector::Zero(layout.size());  // truth − estimate
    error.segment<3>(a) = random.vector(kOfFix);
    error.segment<3>(s) = scale;
    ErrorsInVariables of(options, layout);
    for (int k = 1; k <= kSteps; ++k) {
      const Vector3d noise = random.vector(options.sensor.gyro.noise / std::sqrt(kStep));
      const Vector3d rate = Vector3d::Constant(kSwing * std::sin(0.1 * k));
      // The estimate turns by (rate + noise) less the part that the scale is known to have.
      Covariance Phi = Covariance::Identity(layout.size(), layout.size());
      Phi.block<3, 3>(a, s).diagonal() = -kStep * (rate + noise);
      error.segment<3>(a) -= kStep * (rate.cwiseProduct(error.segment<3>(s)) + noise);
      P = (Phi * P * Phi.transpose()).eval();
      P.diagonal().segment<3>(a).array() += square(options.sensor.gyro.noise) * kStep;
      of.add(kStep);
      if (k % kEvery > 0) continue;
      const Linearization lin = fix_of(Block::kAttitude, square(kOfFix));
      const Update u = innovate(P, layout, lin);
      of.observe({}, P, kNoGravity, u, lin);
      error -= gain(u) * (error.segment<3>(a) + random.vector(kOfFix));
      update(P, u);
      const auto of_noise = of.after_fixes({});
      if (!of_noise) continue;
      if (removes) {
        const auto removed = removing(of_noise->information.head<3>(), layout, Block::kGyroScale, P);
        if (removed) update(P, *removed);
      }
      error += pull_of(of_noise->score, layout, P);
    }
    sum += error.segment<3>(s).cwiseAbs2().cwiseQuotient(P.diagonal().segment<3>(s)).sum();
  }
  return sum / (3 * kRuns);
}

// J + F scatters the estimate, and J is what the covariance has in the end.
TEST(ErrorsInVariables, WithoutFalseInformationTheVarianceIsNearerToThatOfTheError) {
  const double removed = mean_of_squares(true), left = mean_of_squares(false);
  EXPECT_LT(removed, 1.5);
  EXPECT_GT(left, 1.1 * removed);
}

TEST(ErrorsInVariables, InformationIsRemovedFromTheScalesAlone) {
  const StateLayout layout(kAll);
  const Eigen::Index n = layout.size();
  const int s = layout.offset(Block::kGyroScale);
  Covariance P = Covariance::Identity(n, n);
  for (Eigen::Index k = 1; k < n; ++k) P(k, k - 1) = P(k - 1, k) = 0.4;
  const Vector3d part(0.01, 0.1, 0);
  const auto removed_by = [&](const Vector3d& information) {
    Covariance Q = P;
    const auto u = removing(information, layout, Block::kGyroScale, P);
    EXPECT_TRUE(u);
    if (u) update(Q, *u);
    return Eigen::MatrixXd(Eigen::MatrixXd(P).inverse() - Eigen::MatrixXd(Q).inverse());
  };
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(n, n);
  expected.diagonal().segment<3>(s) = part;
  EXPECT_LT((removed_by(part) - expected).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(removed_by({9, 9, 9})(s, s), 0.25, 1e-12);  // never all

  EXPECT_FALSE(removing({1e-9, 0, 0}, layout, Block::kGyroScale, P));
  EXPECT_FALSE(removing({1, 1, 1}, StateLayout(std::vector<Block>{}), Block::kGyroScale, P));
  P.diagonal()(s) = 0;  // known exactly
  EXPECT_FALSE(removing({1, 1, 1}, layout, Block::kGyroScale, P));
}

TEST(ErrorsInVariables, ThePullIsTheCovarianceTimesTheScore) {
  const StateLayout layout(std::vector<Block>{Block::kAccelScale});
  Covariance P = Covariance::Identity(layout.size(), layout.size());
  const int s = layout.offset(Block::kAccelScale);
  P(0, s + 1) = P(s + 1, 0) = 0.5;
  ScaleScore score = ScaleScore::Zero();
  score << 7, 7, 7, 0, 2, 0;  // the gyroscopes' scale is not estimated
  const ErrorVector pull = pull_of(score, layout, P);
  EXPECT_EQ(pull(0), 1);
  EXPECT_EQ(pull(s + 1), 2);
  EXPECT_EQ(pull.cwiseAbs().sum(), 3);
  ErrorVector lambda = ErrorVector::Zero(layout.size());
  add_score(lambda, layout, score);
  EXPECT_EQ(lambda(s + 1), 2);
  EXPECT_EQ(lambda.cwiseAbs().sum(), 2);
}

}  // namespace
}  // namespace piste
