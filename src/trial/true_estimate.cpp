#include "trial/true_estimate.h"

#include <Eigen/QR>
#include <algorithm>
#include <utility>

#include "model/imu_error_model.h"

namespace piste {
namespace {

// Index of the time nearest to `time`. @pre there is one
template <class Samples, class Time>
std::size_t nearest(const Samples& samples, double time, Time&& of) {
  auto after = std::partition_point(samples.begin(), samples.end(), [&](const auto& s) { return of(s) < time; });
  if (after == samples.end() || (after != samples.begin() && time - of(*(after - 1)) < of(*after) - time)) --after;
  return static_cast<std::size_t>(after - samples.begin());
}

}  // namespace

TrueEstimate::TrueEstimate(const Scenario& scenario, const Simulation& simulation, World world, std::uint64_t seed,
                           std::vector<ImuSensor> imus)
    : simulation_(simulation), imus_(std::move(imus)), world_(std::move(world)) {
  const ImuSetup& setup = scenario.imus.front();
  const SimulatedImu& imu = simulation.imus.front();
  for (const ImuSetup& other : scenario.imus) {
    axes_.push_back((setup.q_rb.conjugate() * other.q_rb).toRotationMatrix());
  }
  constant_.gyro_bias = imu.gyro.bias;
  constant_.accel_bias = imu.accel.bias;
  constant_.gyro_scale = imu.gyro.scale;
  constant_.accel_scale = imu.accel.scale;
  const auto put_elements = [&](Block block, const Matrix3d& M) {
    Eigen::Index k = 0;
    for (const auto& [input, signal] : elements_of(block)) additive(constant_, block)(k++) = M(input % 3, signal % 3);
  };
  put_elements(Block::kGyroCrossAxis, (1 + imu.gyro.scale.array()).matrix().asDiagonal() * imu.gyro.misalignment);
  put_elements(Block::kAccelCrossAxis, (1 + imu.accel.scale.array()).matrix().asDiagonal() * imu.accel.misalignment);
  put_elements(Block::kGyroGSensitivity, imu.g_sensitivity);
  constant_.q_rb = setup.q_rb;
  constant_.hard_iron = imu.hard_iron;
  constant_.soft_iron_x = imu.soft_iron.row(0);
  constant_.soft_iron_y = imu.soft_iron.row(1);
  constant_.soft_iron_z = imu.soft_iron.row(2);
  if (scenario.aids.vehicle) {
    const TrueMounting mounting = true_mounting(scenario.q_tr, setup.q_rb, setup.p_rb_r);
    constant_.q_vb = mounting.q_vb;
    constant_.vehicle_contact = mounting.contact;
  }
  const SimulatedAids& aids = simulation.aids;
  constant_.odometer_scale = aids.odometer_scale;
  const auto along_x = [](const std::vector<double>& values) {
    std::vector<Vector3d> out;
    out.reserve(values.size());
    for (const double value : values) out.emplace_back(value, 0, 0);
    return out;
  };
  wheel_slip_ = timed(aids.speed, along_x(aids.wheel_slip));
  barometer_offset_ = timed(aids.height, along_x(aids.barometer_offset));
  for (std::size_t r = scenario.gnss.size(); r-- > 0;) {
    const GnssSetup& receiver = scenario.gnss[r];
    constant_.lever_arm = lever_arm(setup, receiver);  // of the first one
    constant_.gnss_delay = receiver.delay;
    constant_.velocity_delay = receiver.delay_of_velocity();
    if (receiver.position_drift && r < kDriftingReceivers) {
      position_drift_[r] = timed(simulation.gnss[r], position_drift(simulation.plate, receiver, seed));
      if (!simulation.gnss[r].fixes.empty()) stated_[r] = simulation.gnss[r].fixes.front().sigma_position;
    }
  }
  for (std::size_t r = scenario.attitude.size(); r-- > 0;) {
    const AttitudeSetup& reference = scenario.attitude[r];
    constant_.attitude_delay = reference.delay;
    if (!reference.drift) continue;
    attitude_drift_ = timed(simulation.attitude[r], attitude_drift(simulation.plate, reference, seed));
  }
}

template <class Recording>
std::vector<TrueEstimate::Sample> TrueEstimate::timed(const Recording& recording, const std::vector<Vector3d>& values) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < values.size(); ++i) samples.push_back({recording.fixes[i].time, values[i]});
  return samples;
}

// Turns an error along the axes of an IMU into the axes of the first one.
Vector3d TrueEstimate::in_first(std::size_t imu, const Vector3d& value) const { return axes_[imu] * value; }

// The errors of several IMUs as errors of their mean and of the parities. Scales stay along the axes of each IMU.
void TrueEstimate::split(Estimate& x, double time) const {
  const auto count = static_cast<Eigen::Index>(imus_.size());
  const auto put = [&](Block block, TriadMember triad, ImuErrorKind kind, auto&& of) {
    const ImuVector weights = imu_weights(imus_, triad);
    const ErrorSplit s = split_errors(weights, imu_sigmas(imus_, triad, kind));
    Eigen::Matrix<double, Eigen::Dynamic, 3> errors(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) errors.row(i) = of(static_cast<std::size_t>(i)).transpose();
    const Eigen::RowVector3d mean = weights.transpose() * errors;
    additive(x, block) = mean.transpose();
    if (s.split.isZero(0)) return;
    const Eigen::MatrixXd parities = Eigen::MatrixXd(s.split).colPivHouseholderQr().solve(
        Eigen::MatrixXd(errors - Eigen::MatrixXd(s.common) * mean));
    for (int p = 0; p + 1 < count; ++p) additive(x, parity_block(block, p)) = parities.row(p).transpose();
  };
  const auto& imus = simulation_.imus;
  const auto now = [&](std::size_t i) { return nearest(imus[i].gps_time, time, [](double t) { return t; }); };
  const TriadMember gyro = &ImuSensor::gyro, accel = &ImuSensor::accel;
  put(Block::kGyroBias, gyro, ImuErrorKind::kBias, [&](std::size_t i) { return in_first(i, imus[i].gyro.bias); });
  put(Block::kAccelBias, accel, ImuErrorKind::kBias, [&](std::size_t i) { return in_first(i, imus[i].accel.bias); });
  put(Block::kGyroDrift, gyro, ImuErrorKind::kDrift,
      [&](std::size_t i) { return in_first(i, imus[i].gyro_drift[now(i)]); });
  put(Block::kAccelDrift, accel, ImuErrorKind::kDrift,
      [&](std::size_t i) { return in_first(i, imus[i].accel_drift[now(i)]); });
  put(Block::kGyroScale, gyro, ImuErrorKind::kScale,
      [&](std::size_t i) { return TurnedScale(axes_[i]).ordered(imus[i].gyro.scale); });
  put(Block::kAccelScale, accel, ImuErrorKind::kScale,
      [&](std::size_t i) { return TurnedScale(axes_[i]).ordered(imus[i].accel.scale); });
}

void TrueEstimate::set_clock(double drift, double from) {
  constant_.clock_drift = drift;
  clock_from_ = from;
}

Estimate TrueEstimate::at(double stamp) const {
  const double time = stamp - constant_.clock_drift * (stamp - clock_from_);
  const Truth& body = simulation_.bodies.front();
  const SimulatedImu& imu = simulation_.imus.front();
  const TruthState truth = body.at(time);
  const World& simulated = body.world();
  Estimate x = constant_;
  x.p_wb = world_.from_geodetic(simulated.to_geodetic(truth.p_wb));
  const Quaterniond turn(world_.rotation_wn(x.p_wb) * simulated.rotation_wn(truth.p_wb).transpose());
  x.q_wb = (turn * truth.q_wb).normalized();
  x.v_wb = turn * truth.v_wb;
  const auto row = nearest(imu.gps_time, time, [](double t) { return t; });
  x.gyro_drift = imu.gyro_drift[row];
  x.accel_drift = imu.accel_drift[row];
  if (!imus_.empty()) split(x, time);
  if (!imu.magnetic_disturbance.empty()) x.magnetic_disturbance = imu.magnetic_disturbance[row];
  const auto time_of = [](const Sample& s) { return s.time; };
  for (std::size_t r = 0; r < position_drift_.size(); ++r) {
    const std::vector<Sample>& samples = position_drift_[r];
    if (samples.empty()) continue;
    const Vector3d error = samples[nearest(samples, time, time_of)].value;
    additive(x, position_drift_block(static_cast<int>(r), false)) = error;
    additive(x, position_drift_block(static_cast<int>(r), true)) = error.cwiseQuotient(stated_[r]);
  }
  if (!wheel_slip_.empty()) x.wheel_slip = wheel_slip_[nearest(wheel_slip_, time, time_of)].value.x();
  if (!barometer_offset_.empty()) {
    x.barometer_offset = barometer_offset_[nearest(barometer_offset_, time, time_of)].value.x();
  }
  if (!attitude_drift_.empty()) {
    const Vector3d& drift = attitude_drift_[nearest(attitude_drift_, time, time_of)].value;  // in the simulated w
    x.attitude_drift = simulated.rotation_wn(truth.p_wb).transpose() * drift;
  }
  return x;
}

}  // namespace piste
