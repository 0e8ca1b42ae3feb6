// The error's transition against the difference of two strapdown runs, and the block algebra against dense matrices.

#include "model/dynamics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/blocks.h"
#include "support/motion.h"
#include "support/random.h"

namespace piste {
namespace {

using Eigen::MatrixXd;
using test::Random;
using test::WildMotion;

FilterOptions drifting_options() {
  FilterOptions o;
  o.sensor.gyro = {1e-3, 0.01, {DriftProcess::Kind::kGaussMarkov, 2e-4, 20, 0}, 0.01, 0};
  o.sensor.accel = {3e-3, 0.05, {DriftProcess::Kind::kRandomWalk, 0, 0, 1e-3}, 0.02, 0};
  o.gnss.push_back({"", Vector3d::Zero(), true, true, GaussMarkov{{0.4, 0.5, 0.7}, 60}});
  o.attitude.push_back({"", GaussMarkov{{0.001, 0.001, 0.003}, 30}, GaussMarkov{{0.002, 0.001, 0.002}, 45}});
  return o;
}

// Error of each block that is about as large as every other one in its effect.
FullError typical_error() {
  FullError e;
  for (const BlockInfo& row : kBlocks) {
    const bool angle = row.unit == "deg" || row.unit == "deg/s" || row.unit == "ppm";
    const bool sensitivity = row.block == Block::kGyroGSensitivity;  // rad/s for 10 m/s²
    e.segment(full_offset(row.block), row.size).setConstant(sensitivity ? 0.001 : angle ? 0.01 : 0.1);
  }
  return e;
}

const StepNoise kNoNoise{Vector3d::Zero(), Vector3d::Zero()};

struct Earth {
  Vector3d rate;
  Gravity here;
  Gravity gravity(const Vector3d& p) const { return {p, here.at(p), here.gradient}; }
};

Earth ordinary_earth() {
  const World world({0.8, 0.1, 500});
  return {world.earth_rate(), world.gravity(Vector3d::Zero())};
}

// One that turns fast and pulls unevenly, so that no term of the dynamics is too small to be seen.
Earth wild_earth() {
  const Matrix3d gradient = (Matrix3d() << 0.3, 0.1, -0.2, 0.1, -0.4, 0.2, -0.2, 0.2, 0.1).finished();
  return {{0.2, -0.1, 0.3}, {Vector3d::Zero(), {0.3, -0.2, 9.8}, gradient}};
}

struct Run {
  Estimate x;
  MatrixXd Phi;
};

// Carries an estimate over raw steps as the filter does; `with_transition` accumulates Φ along it.
Run run(Estimate x, const std::vector<ImuStep>& steps, const Earth& earth, bool with_transition) {
  const StateLayout layout(test::most_blocks());
  const FilterOptions options = drifting_options();
  Run r;
  r.Phi.setIdentity(layout.size(), layout.size());
  for (const ImuStep& raw : steps) {
    const ImuStep step = correct(raw, x);
    const Estimate before = x;
    const Gravity gravity = earth.gravity(x.p_wb);
    mechanize(x, step, earth.rate, gravity);
    Transition t = linearize(before, x, step, earth.rate, gravity, kNoNoise);
    add_processes(t, layout, options, raw.dt);
    decay(x, layout, t);
    if (with_transition) r.Phi = dense_transition(layout, t) * r.Phi;
  }
  r.x = x;
  return r;
}

// Largest difference between Φ and the central difference of strapdown runs, both in units of typical errors, relative
// to the largest entry.
double transition_error(const Estimate& x, const std::vector<ImuStep>& steps, const Earth& earth = ordinary_earth()) {
  const Run nominal = run(x, steps, earth, true);
  const FullError unit = typical_error();
  const Eigen::Index n = nominal.Phi.rows();  // the blocks of a run are the first ones
  MatrixXd numeric(n, n);
  constexpr double h = 1e-4;
  for (Eigen::Index k = 0; k < n; ++k) {
    const FullError e = h * unit(k) * FullError::Unit(k);
    const Estimate plus = run(boxplus(x, e), steps, earth, false).x, minus = run(boxplus(x, -e), steps, earth, false).x;
    numeric.col(k) = (boxminus(plus, nominal.x) - boxminus(minus, nominal.x)).head(n) / (2 * h);
  }
  const auto scaled = [&](const MatrixXd& m) -> MatrixXd { return unit.head(n).cwiseInverse().asDiagonal() * m; };
  const MatrixXd claimed = scaled(nominal.Phi * unit.head(n).asDiagonal());
  return (claimed - scaled(numeric)).cwiseAbs().maxCoeff() / claimed.cwiseAbs().maxCoeff();
}

std::vector<ImuStep> wild_steps(double start, double duration, double dt) {
  const WildMotion motion;
  const auto samples = motion.samples(start, start + duration, dt);
  std::vector<ImuStep> steps;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    steps.push_back(
        make_step(i > 0 ? &samples[i - 1] : nullptr, samples[i], i + 1 < samples.size() ? &samples[i + 1] : nullptr));
  }
  return steps;
}

// At rest the samples are noise: neither heading nor scales may be regressed on it.
TEST(Dynamics, TransitionAtRestDoesNotDependOnTheNoiseOfTheSamples) {
  Random random(9);
  const Earth earth = ordinary_earth();
  Estimate x;
  x.q_wb = from_euler({0.1, -0.7, 2});
  const Vector3d standing = -(x.q_wb.conjugate() * earth.here.value);
  const auto at_rest = [&] {
    x.v_wb = random.vector(0.02);
    const ImuStep step{0.01, random.vector(1e-3), random.vector(0.1), random.vector(1e-3), random.vector(0.1)};
    return linearize(x, x, step, earth.rate, earth.here, kNoNoise, &standing);
  };
  const Transition a = at_rest(), b = at_rest();
  EXPECT_EQ(a.rate, Vector3d::Zero().eval());
  EXPECT_EQ(a.force, b.force);
  EXPECT_EQ(a.force, standing);
  EXPECT_EQ(a.navigation, b.navigation);
}

// A scale that was propagated with a noisy rate, and is told of the noise afterwards, stands as if there had been none.
TEST(Dynamics, MendedRateIsTheRateWithoutNoise) {
  const std::array blocks{Block::kGyroBias, Block::kGyroScale, Block::kAccelScale};
  const StateLayout layout(blocks);
  const Earth earth = ordinary_earth();
  Random random(4);
  const double dt = 1e-3;
  for (int trial = 0; trial < 20; ++trial) {
    Estimate x = random.estimate();
    const Vector3d rate = random.vector(0.3), noise = random.vector(0.5), force = random.vector(10);
    const auto transition = [&](const Vector3d& w) {
      const ImuStep step{dt, w * dt, force * dt, Vector3d::Zero(), Vector3d::Zero()};
      return linearize(x, x, step, earth.rate, earth.here, kNoNoise);
    };
    Covariance seen = random.covariance(layout.size());
    Covariance clean = seen;
    propagate(seen, layout, transition(rate + noise));
    propagate(clean, layout, transition(rate));
    Covariance mended = seen;
    propagate(mended, layout, mend_rate(x, -(x.q_wb * noise) * dt));
    EXPECT_LT((mended - clean).norm(), 0.01 * (seen - clean).norm());
  }
}

// Products of cross-axis errors with other errors are left out of Φ: here they are a thousandth of what is tested.
Estimate nearly_square(Random& random) {
  Estimate x = random.estimate();
  x.gyro_cross_axis *= 1e-4;
  x.accel_cross_axis *= 1e-4;
  x.gyro_g_sensitivity *= 1e-4;
  return x;
}

TEST(Dynamics, TransitionIsTheDifferenceOfTwoRunsOverOneStep) {
  Random random(1);
  for (int i = 0; i < 10; ++i) {
    const Estimate x = nearly_square(random);
    const double coarse = transition_error(x, wild_steps(i, 0.01, 0.01));
    const double fine = transition_error(x, wild_steps(i, 0.005, 0.005));
    EXPECT_LT(coarse, 1e-4);
    EXPECT_GT(std::log2(coarse / fine), 2.7) << coarse << " " << fine;  // of one step: third order
    // Where the Earth's turn within a step counts, second order is left; a term that is missing or wrong is of first.
    const double coarse_wild = transition_error(x, wild_steps(i, 0.01, 0.01), wild_earth());
    const double fine_wild = transition_error(x, wild_steps(i, 0.005, 0.005), wild_earth());
    EXPECT_LT(coarse_wild, 3e-4);
    EXPECT_GT(std::log2(coarse_wild / fine_wild), 1.9) << coarse_wild << " " << fine_wild;
  }
}

TEST(Dynamics, TransitionIsOfSecondOrderOverManySteps) {
  Random random(2);
  const WildMotion motion;
  for (int i = 0; i < 3; ++i) {
    Estimate x = nearly_square(random);
    const auto at = motion.at(3);
    x.q_wb = at.q_wb;
    x.v_wb = at.v_wb;
    const double coarse = transition_error(x, wild_steps(3, 1, 0.02));
    const double fine = transition_error(x, wild_steps(3, 1, 0.01));
    EXPECT_LT(fine, 1e-3);
    EXPECT_GT(std::log2(coarse / fine), 1.8) << coarse << " " << fine;
  }
}

class Layouts : public testing::TestWithParam<std::vector<Block>> {};

INSTANTIATE_TEST_SUITE_P(Dynamics, Layouts,
                         testing::Values(std::vector<Block>{}, std::vector<Block>{Block::kGyroBias, Block::kAccelBias},
                                         std::vector<Block>{Block::kGyroDrift, Block::kGnssDelay},
                                         std::vector<Block>{Block::kAccelScale, Block::kLeverArm,
                                                            Block::kAttitudeDrift},
                                         std::vector<Block>{Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift,
                                                            Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale},
                                         test::most_blocks()));

// One step of wild motion with white noise and every process.
Transition some_step(const StateLayout& layout, Random& random) {
  const WildMotion motion;
  Estimate x = random.estimate();
  const ImuStep step = correct(wild_steps(2, 0.01, 0.01).front(), x);
  Estimate end = x;
  const Gravity gravity = motion.world.gravity(x.p_wb);
  mechanize(end, step, motion.world.earth_rate(), gravity);
  const StepNoise noise{random.vector().cwiseAbs2(), random.vector().cwiseAbs2()};
  Transition t = linearize(x, end, step, motion.world.earth_rate(), gravity, noise);
  add_processes(t, layout, drifting_options(), 5.0);
  return t;
}

MatrixXd dense_noise(const StateLayout& layout, const Transition& t) {
  MatrixXd Q = MatrixXd::Zero(layout.size(), layout.size());
  Q.topLeftCorner<9, 9>() = t.noise;
  for (const Block b : layout.blocks()) {
    Q.diagonal().segment(layout.offset(b), info(b).size) +=
        t.variance[static_cast<std::size_t>(index_of(b))].head(info(b).size);
  }
  return Q;
}

double relative(const MatrixXd& a, const MatrixXd& b) { return (a - b).norm() / b.norm(); }

TEST_P(Layouts, PropagationIsTheDenseProduct) {
  Random random(3);
  const StateLayout layout(GetParam());
  for (int i = 0; i < 10; ++i) {
    const Transition t = some_step(layout, random);
    Covariance P = random.covariance(layout.size());
    const MatrixXd Phi = dense_transition(layout, t);
    const MatrixXd expected = Phi * P * Phi.transpose() + dense_noise(layout, t);
    propagate(P, layout, t);
    EXPECT_LT(relative(P, expected), 1e-14);
    EXPECT_TRUE(P == P.transpose());
  }
}

TEST_P(Layouts, AnErrorIsPropagatedByTheDenseTransition) {
  Random random(5);
  const StateLayout layout(GetParam());
  for (int i = 0; i < 10; ++i) {
    const Transition t = some_step(layout, random);
    ErrorVector m = random.matrix(layout.size(), 1);
    const MatrixXd expected = dense_transition(layout, t) * m;
    propagate(m, layout, t);
    EXPECT_LT(relative(m, expected), 1e-14);
  }
}

// exp(M), by its series for M / 2^k and k squarings.
MatrixXd exponential(const MatrixXd& M) {
  const int k = std::max(0, std::ilogb(M.norm()) + 4);
  MatrixXd sum = MatrixXd::Identity(M.rows(), M.cols()), term = sum;
  for (int i = 1; i <= 20; ++i) {
    term = (term * std::ldexp(1.0, -k) * M / i).eval();
    sum += term;
  }
  for (int i = 0; i < k; ++i) sum = (sum * sum).eval();
  return sum;
}

// Φ and Q of dx/dt = A x + w, E[w wᵀ] = W, over dt, by one matrix exponential (van Loan 1978).
struct Discrete {
  MatrixXd Phi, Q;
};
Discrete van_loan(const MatrixXd& A, const MatrixXd& W, double dt) {
  const Eigen::Index n = A.rows();
  MatrixXd M = MatrixXd::Zero(2 * n, 2 * n);
  M.topLeftCorner(n, n) = A * dt;
  M.topRightCorner(n, n) = W * dt;
  M.bottomRightCorner(n, n) = -A.transpose() * dt;
  const MatrixXd E = exponential(M);
  const MatrixXd Phi = E.topLeftCorner(n, n);
  return {Phi, E.topRightCorner(n, n) * Phi.transpose()};
}

TEST(Processes, GaussMarkovIsVanLoan) {
  for (const double tau : {0.1, 20.0, 1e5}) {
    for (const double dt : {1e-3, 0.01, 5.0}) {
      const DiscreteProcess d = discretise({DriftProcess::Kind::kGaussMarkov, 0.3, tau, 0}, dt);
      const MatrixXd A = MatrixXd::Constant(1, 1, -1 / tau), W = MatrixXd::Constant(1, 1, 2 * 0.3 * 0.3 / tau);
      const Discrete expected = van_loan(A, W, dt);
      EXPECT_NEAR(d.transition, expected.Phi(0, 0), 1e-13);
      EXPECT_NEAR(d.variance / expected.Q(0, 0), 1, 1e-9);
      // Lyapunov: the stationary variance stays.
      EXPECT_NEAR(d.transition * d.transition * 0.09 + d.variance, 0.09, 1e-16);
    }
  }
}

TEST(Processes, RandomWalkIsItsIntegralAndNoneIsConstant) {
  const DiscreteProcess walk = discretise({DriftProcess::Kind::kRandomWalk, 0, 0, 0.02}, 0.5);
  EXPECT_EQ(walk.transition, 1);
  EXPECT_DOUBLE_EQ(walk.variance, 0.02 * 0.02 * 0.5);
  const DiscreteProcess none = discretise({}, 0.5);
  EXPECT_EQ(none.transition, 1);
  EXPECT_EQ(none.variance, 0);
}

TEST(Processes, StepsComposeToOneLongStep) {
  const DriftProcess process{DriftProcess::Kind::kGaussMarkov, 0.3, 7, 0};
  const DiscreteProcess a = discretise(process, 0.3), b = discretise(process, 1.1), whole = discretise(process, 1.4);
  EXPECT_NEAR(a.transition * b.transition, whole.transition, 1e-15);
  EXPECT_NEAR(b.transition * b.transition * a.variance + b.variance, whole.variance, 1e-15);
}

// A body under constant force that does not turn in w, so that the continuous system is known: a chain of steps against
// van Loan of (ρ, ν, θ), drifts of the gyro and of the accelerometer. Velocity stays within a factor of two.
TEST(Dynamics, NoiseOfManyStepsIsVanLoanOfTheContinuousSystem) {
  const StateLayout layout(std::vector<Block>{Block::kGyroDrift, Block::kAccelDrift});
  FilterOptions options = drifting_options();
  options.sensor.gyro.drift = {DriftProcess::Kind::kGaussMarkov, 0.01, 3, 0};
  options.sensor.accel.drift = {DriftProcess::Kind::kGaussMarkov, 0.1, 5, 0};
  const World world({0.8, 0.1, 0});
  const Vector3d earth = world.earth_rate();
  Random random(5);
  Estimate x;
  x.q_wb = random.rotation();
  x.v_wb = Vector3d(12, -5, 2);
  x.gyro_scale = Vector3d(0.02, -0.03, 0.01);
  x.accel_scale = Vector3d(-0.02, 0.01, 0.03);
  const Matrix3d R = x.R_wb();
  const double gyro = 1e-3, accel = 3e-3;

  const Gravity gravity = world.gravity(Vector3d::Zero());
  const Vector3d v = x.v_wb;
  MatrixXd A = MatrixXd::Zero(15, 15), G = MatrixXd::Zero(15, 12);
  const Matrix3d V = skew(v), E = skew(earth);
  const Matrix3d B_g = R * (1 + x.gyro_scale.array()).inverse().matrix().asDiagonal();
  const Matrix3d B_a = R * (1 + x.accel_scale.array()).inverse().matrix().asDiagonal();
  A.block<3, 3>(0, 3).setIdentity();
  A.block<3, 3>(0, 6) = -V;
  A.block<3, 3>(3, 0) = gravity.gradient;
  A.block<3, 3>(3, 3) = -2 * E;
  A.block<3, 3>(3, 6) = skew(gravity.value) + V * E;
  A.block<3, 3>(6, 6) = -E;
  A.block<3, 3>(3, 9) = -V * B_g;
  A.block<3, 3>(6, 9) = -B_g;
  A.block<3, 3>(3, 12) = -B_a;
  A.block<3, 3>(9, 9) = -Matrix3d::Identity() / 3;
  A.block<3, 3>(12, 12) = -Matrix3d::Identity() / 5;
  G.block<3, 3>(3, 0) = -V * B_g;
  G.block<3, 3>(6, 0) = -B_g;
  G.block<3, 3>(3, 3) = -B_a;
  G.block<3, 3>(9, 6).setIdentity();
  G.block<3, 3>(12, 9).setIdentity();
  Eigen::VectorXd W(12);
  W << Vector3d::Constant(gyro * gyro), Vector3d::Constant(accel * accel), Vector3d::Constant(2 * 1e-4 / 3),
      Vector3d::Constant(2 * 1e-2 / 5);
  const double duration = 1;
  const Discrete expected = van_loan(A, G * W.asDiagonal() * G.transpose(), duration);

  Covariance P = Covariance::Zero(15, 15);
  const int steps = 200;
  const double dt = duration / steps;
  for (int i = 0; i < steps; ++i) {
    // The increments that hold attitude and velocity, in w: rate of the Earth and −g + 2 ω × v.
    const ImuStep step{dt, R.transpose() * earth * dt, R.transpose() * (-gravity.value + 2 * earth.cross(v)) * dt,
                       Vector3d::Zero(), Vector3d::Zero()};
    Transition t =
        linearize(x, x, step, earth, gravity, {Vector3d::Constant(gyro * gyro), Vector3d::Constant(accel * accel)});
    add_processes(t, layout, options, dt);
    propagate(P, layout, t);
  }
  const Eigen::VectorXd sigma = expected.Q.diagonal().cwiseSqrt();
  const MatrixXd scale = sigma.cwiseInverse().asDiagonal();
  const MatrixXd difference = scale * (P - expected.Q) * scale;
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 3.0 / steps) << difference;
}

}  // namespace
}  // namespace piste
