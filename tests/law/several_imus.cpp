// Several IMUs as one: mechanizing their mean and measuring their parities is the filter over their stacked outputs.

#include <gtest/gtest.h>

#include <array>

#include "model/dynamics.h"
#include "piste/filter/initial_state.h"
#include "piste/filter/update.h"
#include "piste/model/imu_parity.h"
#include "support/random.h"

namespace piste {
namespace {

using test::Random;

constexpr int kUnits = 3, kErrors = 18, kSteps = 60;
constexpr double kStep = 0.01;
constexpr std::array<Block, kImuErrors> kKinds{Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
                                               Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};

using Axes = std::array<Matrix3d, kUnits>;

// All along one another, or turned against the first: by an angle near 45 degrees, and about another axis by nearly 90.
Axes unturned() { return {Matrix3d::Identity(), Matrix3d::Identity(), Matrix3d::Identity()}; }
Axes turned() {
  return {Matrix3d::Identity(), so3_exp(Vector3d(0.1, -0.78, 0.3)).toRotationMatrix(),
          so3_exp(Vector3d(-0.05, 0.02, 1.5)).toRotationMatrix()};
}

// Units that differ in everything but the correlation time of their drifts.
std::vector<ImuSensor> imus(DriftProcess::Kind drift) {
  std::vector<ImuSensor> out(kUnits);
  for (int i = 0; i < kUnits; ++i) {
    const double factor = 1 + 0.7 * i;
    TriadErrors& gyro = out[static_cast<std::size_t>(i)].gyro;
    TriadErrors& accel = out[static_cast<std::size_t>(i)].accel;
    gyro = {.noise = 8.7e-4 * factor, .bias = 8.7e-3 / factor, .drift = {}, .scale = 0.01 * factor};
    accel = {.noise = 2e-3 / factor, .bias = 0.05 * factor, .drift = {}, .scale = 0.02 / factor};
    gyro.drift = {drift, 2e-3 * factor * factor, 5, 2e-3 * factor * factor};
    accel.drift = {drift, 0.02 / factor, 9, 0.02 / factor};
  }
  return out;
}

// The filter over stacked outputs. Its state: (ρ, ν, θ), and of each unit bias, drift and scale, in the order of
// kKinds; scales along the axes of the unit.
struct Stacked {
  Axes axes;
  static constexpr int kSize = 9 + kUnits * kErrors;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(kSize);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(kSize, kSize);

  static int place(int unit, int kind) { return 9 + kErrors * unit + 3 * kind; }

  // The error of the outputs (rate, force) of a unit, along the axes of the first.
  Eigen::MatrixXd error_of(int unit, const Vector3d& rate, const Vector3d& force) const {
    const Matrix3d& R = axes[static_cast<std::size_t>(unit)];
    Eigen::MatrixXd E = Eigen::MatrixXd::Zero(6, kSize);
    for (int kind = 0; kind < kImuErrors; ++kind) {
      const Vector3d own = R.transpose() * (kind == 4 ? rate : force);
      E.block<3, 3>(kind % 2 == 0 ? 0 : 3, place(unit, kind)) =
          kind < 4 ? Matrix3d::Identity().eval() : Matrix3d(R * own.asDiagonal());
    }
    return E;
  }
  void update(const Eigen::MatrixXd& H, const Eigen::VectorXd& z, const Eigen::MatrixXd& R) {
    const Eigen::MatrixXd K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
    mean += K * (z - H * mean);
    const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - K * H;
    P = I_KH * P * I_KH.transpose() + K * R * K.transpose();
  }
};

using Outputs = std::array<Eigen::Matrix<double, 6, 1>, kUnits>;

Eigen::Matrix<double, 6, 1> noise_variance(const ImuSensor& sensor) {
  Eigen::Matrix<double, 6, 1> out;
  out << sensor.gyro.noise_variance(), sensor.accel.noise_variance();
  return out / kStep;
}

// One step about the mean output: the true input is the output of the first unit less its error and its noise, which
// stand in the state while the outputs of the others tell of them.
void step(Stacked& s, const std::vector<ImuSensor>& sensors, const Transition& t, const Outputs& beside_mean) {
  const int n = Stacked::kSize;
  Stacked wide{s.axes};
  wide.mean = Eigen::VectorXd::Zero(n + 6);
  wide.mean.head(n) = s.mean;
  wide.P = Eigen::MatrixXd::Zero(n + 6, n + 6);
  wide.P.topLeftCorner(n, n) = s.P;
  wide.P.bottomRightCorner(6, 6) = noise_variance(sensors[0]).asDiagonal();
  const Eigen::MatrixXd first = s.error_of(0, t.rate, t.force);
  for (int i = 1; i < kUnits; ++i) {
    Eigen::MatrixXd H(6, n + 6);
    H << s.error_of(i, t.rate, t.force) - first, -Eigen::MatrixXd::Identity(6, 6);
    const auto unit = static_cast<std::size_t>(i);
    wide.update(H, beside_mean[unit] - beside_mean[0], noise_variance(sensors[unit]).asDiagonal());
  }
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(n, n + 6);
  F.topLeftCorner(n, n).setIdentity();
  F.topLeftCorner<9, 9>() = t.navigation;
  F.topLeftCorner(9, n) += t.imu * first;
  F.topRightCorner<9, 6>() = t.imu;
  Eigen::VectorXd Q = Eigen::VectorXd::Zero(n);
  for (int i = 0; i < kUnits; ++i) {
    for (const int kind : {2, 3}) {
      const ImuSensor& sensor = sensors[static_cast<std::size_t>(i)];
      const DiscreteProcess d = discretise((kind == 2 ? sensor.gyro : sensor.accel).drift, kStep);
      const int at = Stacked::place(i, kind);
      for (int k = 0; k < 3; ++k) F(at + k, at + k) = d.transition;
      Q.segment<3>(at).setConstant(d.variance);
    }
  }
  s.mean = F * wide.mean;
  s.mean.head<9>() -= t.imu * beside_mean[0];
  s.P = F * wide.P * F.transpose();
  s.P.diagonal() += Q;
}

// The matrix from the errors of our layout to those of the stacked filter.
Eigen::MatrixXd to_stacked(const StateLayout& layout, const std::vector<ImuSensor>& sensors, const Axes& axes) {
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(Stacked::kSize, layout.size());
  M.topLeftCorner<9, 9>().setIdentity();
  for (int kind = 0; kind < kImuErrors; ++kind) {
    const Block block = kKinds[static_cast<std::size_t>(kind)];
    const TriadMember triad = kind % 2 == 0 ? &ImuSensor::gyro : &ImuSensor::accel;
    const ErrorSplit split =
        split_errors(imu_weights(sensors, triad), imu_sigmas(sensors, triad, static_cast<ImuErrorKind>(kind / 2)));
    for (int i = 0; i < kUnits; ++i) {
      Matrix3d own = Matrix3d::Identity();  // from the order of our axes to that of the unit's
      if (kind >= 4) {
        const TurnedScale turned(axes[static_cast<std::size_t>(i)]);
        for (int k = 0; k < 3; ++k) own.row(k) = turned.ordered(Vector3d::Unit(k)).transpose();
      }
      M.block<3, 3>(Stacked::place(i, kind), layout.offset(block)) = split.common(i) * own;
      for (int k = 0; k + 1 < kUnits; ++k) {
        M.block<3, 3>(Stacked::place(i, kind), layout.offset(parity_block(block, k))) = split.split(i, k) * own;
      }
    }
  }
  return M;
}

// Runs both filters over random outputs, and compares all states of the stacked one.
void expect_equal(DriftProcess::Kind drift, const Axes& axes) {
  Random random(7);
  FilterOptions options;
  options.imus = imus(drift);
  options.unit_axes = {axes.begin(), axes.end()};
  options.sensor = mean_sensor(options.imus);
  options.estimate = with_implied_blocks(options, {kKinds.begin(), kKinds.end()});
  const StateLayout layout(options.estimate);
  ASSERT_EQ(layout.size(), Stacked::kSize);
  const World world({0.81, 0.13, 800});

  Start start;
  start.covariance = 0.1 * random.covariance(9);
  Covariance P = initial_covariance(layout, options, start);
  ErrorVector m = ErrorVector::Zero(layout.size());
  const Eigen::MatrixXd M = to_stacked(layout, options.imus, axes);
  Stacked stacked{axes};
  stacked.P = M * P * M.transpose();
  for (int i = 0; i < kUnits; ++i) {  // that the units' errors are independent at first
    for (int k = 0; k < i; ++k) {
      EXPECT_LT(stacked.P.block(9 + kErrors * i, 9 + kErrors * k, kErrors, kErrors).cwiseAbs().maxCoeff(), 1e-16);
    }
  }
  const ImuVector w_gyro = imu_weights(options.imus, &ImuSensor::gyro);
  const ImuVector w_accel = imu_weights(options.imus, &ImuSensor::accel);
  const ImuMatrix L_gyro = parity_rows(imu_noise(options.imus, &ImuSensor::gyro));
  const ImuMatrix L_accel = parity_rows(imu_noise(options.imus, &ImuSensor::accel));

  const auto scales = ImuScales::across(options);
  Estimate x;
  x.q_wb = random.rotation();
  x.v_wb = random.vector(10);
  for (int k = 0; k < kSteps; ++k) {
    Outputs outputs;
    Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero();
    const Vector3d rate = random.vector(2), force = random.vector(12);
    for (int i = 0; i < kUnits; ++i) {
      auto& y = outputs[static_cast<std::size_t>(i)];
      y << rate + random.vector(0.02), force + random.vector(0.1);
      mean.head<3>() += w_gyro(i) * y.head<3>();
      mean.tail<3>() += w_accel(i) * y.tail<3>();
    }
    ParityFix fixes[kUnits - 1];
    for (int p = 0; p + 1 < kUnits; ++p) {
      fixes[p] = {
          .duration = kStep, .gyro = Parity{}, .accel = Parity{}, .rate = mean.head<3>(), .force = mean.tail<3>()};
      for (int i = 0; i < kUnits; ++i) {
        fixes[p].gyro->value += L_gyro(i, p) * outputs[static_cast<std::size_t>(i)].head<3>();
        fixes[p].accel->value += L_accel(i, p) * outputs[static_cast<std::size_t>(i)].tail<3>();
      }
    }
    for (auto& y : outputs) y -= mean;

    const Estimate about;  // without errors of the IMUs
    const auto tell = [&](Linearization lin) {
      lin.residual -= assemble(layout, lin) * m;
      const Update u = innovate(P, layout, lin);
      m += gain(u) * u.residual;
      update(P, u);
    };
    for (int p = 0; p + 1 < kUnits; ++p) {
      tell(*linearize_parity(fixes[p], p, &ImuSensor::gyro, options, about));
      tell(*linearize_parity(fixes[p], p, &ImuSensor::accel, options, about));
    }
    const ImuStep s{kStep, kStep * mean.head<3>(), kStep * mean.tail<3>(), Vector3d::Zero(), Vector3d::Zero()};
    const Estimate before = x;
    const Gravity gravity = world.gravity(x.p_wb);
    mechanize(x, s, world.earth_rate(), gravity);
    Transition t = linearize(before, x, s, world.earth_rate(), gravity,
                             {options.sensor.gyro.noise_variance(), options.sensor.accel.noise_variance()});
    t.imu_scales = scales.get();
    add_processes(t, layout, options, kStep);
    propagate(P, layout, t);
    propagate(m, layout, t);
    step(stacked, options.imus, t, outputs);

    if (k % 7 == 0) {  // a fix, which tells the mean IMU apart from the motion
      const Vector3d fix = random.vector(0.5);
      Linearization lin;
      lin.residual = fix;
      lin.covariance = 0.01 * Matrix3d::Identity();
      lin.add(Block::kPosition, Matrix3d::Identity());
      tell(lin);
      Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3, Stacked::kSize);
      H.leftCols<3>().setIdentity();
      stacked.update(H, fix, 0.01 * Eigen::MatrixXd::Identity(3, 3));
    }
  }
  const Eigen::VectorXd mean = M * m;
  const Eigen::MatrixXd covariance = M * P * M.transpose();
  const Eigen::VectorXd sigma = stacked.P.diagonal().cwiseSqrt();
  EXPECT_LT((mean - stacked.mean).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((covariance - stacked.P).cwiseQuotient(sigma * sigma.transpose()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(mean.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.5);  // there was something to tell
}

TEST(SeveralImus, AreTheFilterOverStackedOutputs) { expect_equal(DriftProcess::Kind::kGaussMarkov, unturned()); }
TEST(SeveralImus, AreTheFilterOverStackedOutputsWithRandomWalks) {
  expect_equal(DriftProcess::Kind::kRandomWalk, unturned());
}
TEST(SeveralImus, ThatAreTurnedAreTheFilterOverStackedOutputs) {
  expect_equal(DriftProcess::Kind::kGaussMarkov, turned());
}

FilterOptions options_with(const Axes& axes) {
  FilterOptions options;
  options.imus = imus(DriftProcess::Kind::kGaussMarkov);
  options.unit_axes = {axes.begin(), axes.end()};
  return options;
}

// What is taken off a step leaves what the mean's own scales make of the true one.
TEST(SeveralImus, OnlyTheMeansOwnScalesAreLeftInAStep) {
  Random random(3);
  const Axes axes = turned();
  const FilterOptions options = options_with(axes);
  const ImuVector w = imu_weights(options.imus, &ImuSensor::gyro);
  const ErrorSplit split = split_errors(w, imu_sigmas(options.imus, &ImuSensor::gyro, ImuErrorKind::kScale));
  Estimate x = random.estimate();
  x.gyro_cross_axis.setZero();
  x.accel_cross_axis.setZero();
  x.gyro_g_sensitivity.setZero();
  Matrix3d gain = Matrix3d::Identity();
  for (int i = 0; i < kUnits; ++i) {
    const Matrix3d& R = axes[static_cast<std::size_t>(i)];
    Vector3d scale = split.common(i) * x.gyro_scale;
    for (int k = 0; k + 1 < kUnits; ++k) scale += split.split(i, k) * additive(x, parity_block(Block::kGyroScale, k));
    Vector3d own;
    const Vector3d place = TurnedScale(R).ordered({0, 1, 2});
    for (int k = 0; k < 3; ++k) own(static_cast<int>(place(k))) = scale(k);
    gain += w(i) * R * own.asDiagonal() * R.transpose();
  }
  const Vector3d rate = random.vector(2), slope = random.vector(5), offset = x.gyro_bias + x.gyro_drift;
  const ImuStep measured{0.01, 0.01 * (gain * rate + offset), random.vector(0.1), gain * slope, random.vector(50)};
  const ImuScales scales(options);
  const ImuStep step = correct(scales.without_rest(measured, x), x);
  EXPECT_LT((step.mean_rate() - rate).norm(), 1e-13);
  EXPECT_LT((step.rate_slope - slope).norm(), 1e-13);
  EXPECT_GT((correct(measured, x).mean_rate() - rate).norm(), 1e-3) << "nothing to take off";
}

// About an estimate without scales: those that it has change the effect of others in second order.
TEST(SeveralImus, ScalesActOnAStepAsDifferencesSay) {
  Random random(8);
  FilterOptions options = options_with(turned());
  options.sensor = mean_sensor(options.imus);
  const StateLayout layout(with_implied_blocks(options, {kKinds.begin(), kKinds.end()}));
  const ImuScales scales(options);
  const World world({0.81, 0.13, 800});
  for (int trial = 0; trial < 10; ++trial) {
    Estimate about = random.estimate();
    about.gyro_scale.setZero();
    about.accel_scale.setZero();
    about.parity.fill(Vector3d::Zero());
    constexpr double kShort = 1e-4;  // s: the midpoint of a step is that of its transition
    const ImuStep measured{kShort, kShort * random.vector(3), kShort * random.vector(15), random.vector(5),
                           random.vector(50)};
    const Gravity gravity = world.gravity(about.p_wb);
    const auto after = [&](Estimate x) {
      mechanize(x, correct(scales.without_rest(measured, x), x), world.earth_rate(), gravity);
      return x;
    };
    const ImuStep corrected = correct(scales.without_rest(measured, about), about);
    Transition t = linearize(about, after(about), corrected, world.earth_rate(), gravity, {});
    t.imu_scales = &scales;
    const Covariance Phi = dense_transition(layout, t);
    for (const Block b : layout.blocks()) {
      if (is_navigation(b) || info(b).process) continue;
      for (int k = 0; k < 3; ++k) {
        constexpr double kDeviation = 1e-3;
        ErrorVector e = ErrorVector::Zero(layout.size());
        e(layout.offset(b) + k) = kDeviation;
        const ErrorVector moved = boxminus(after(boxplus(about, layout, e)), after(boxplus(about, layout, -e)), layout);
        const Eigen::Matrix<double, 6, 1> numeric = moved.segment<6>(3) / (2 * kDeviation),
                                          claimed = Phi.col(layout.offset(b) + k).segment<6>(3);
        EXPECT_LE((numeric - claimed).norm(), 1e-3 * numeric.norm()) << info(b).name << " " << k;
      }
    }
  }
}

TEST(SeveralImus, OfUnitsThatAreAlikeTheMeanHasOneOverRootOfTheErrors) {
  std::vector<ImuSensor> alike(4, imus(DriftProcess::Kind::kGaussMarkov)[1]);
  const ImuSensor mean = mean_sensor(alike);
  EXPECT_NEAR(mean.gyro.noise, alike[0].gyro.noise / 2, 1e-15);
  EXPECT_NEAR(mean.accel.bias, alike[0].accel.bias / 2, 1e-15);
  EXPECT_NEAR(mean.gyro.drift.sigma, alike[0].gyro.drift.sigma / 2, 1e-15);
  EXPECT_NEAR(mean.gyro.drift.correlation_time, 5, 1e-12);
}

}  // namespace
}  // namespace piste
