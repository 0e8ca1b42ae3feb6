#include "piste/sim/sensors.h"

#include <algorithm>
#include <cmath>

#include "model/imu_error_model.h"
#include "piste/math/interruption.h"
#include "piste/sim/random.h"
#include "sim/epochs.h"

namespace piste {
namespace {

// Mean and root mean square. 0 if there are no values.
class Moments {
 public:
  void add(const Vector3d& value) {
    sum_ += value;
    squares_ += value.cwiseAbs2();
    ++count_;
  }
  Vector3d mean() const { return sum_ / std::max(1.0, count_); }
  Vector3d rms() const { return (squares_ / std::max(1.0, count_)).cwiseSqrt(); }
  std::size_t count() const { return static_cast<std::size_t>(count_); }

 private:
  Vector3d sum_ = Vector3d::Zero(), squares_ = Vector3d::Zero();
  double count_ = 0;
};

enum Phase : std::size_t { kBefore, kRun, kAfter };

Phase phase_of(double time, const Interval& run) { return time < run.start ? kBefore : time > run.end ? kAfter : kRun; }

// The given constant with its spread; without one, a random value of the sensor's sigma about zero.
Vector3d draw_constant(const std::optional<Vector3d>& given, const Vector3d& spread, double sigma,
                       RandomStream stream) {
  const Vector3d deviation = stream.normal3();
  return given ? Vector3d(*given + spread.cwiseProduct(deviation)) : Vector3d(sigma * deviation);
}

// Adds the errors of one triad, row by row.
class TriadErrorSource {
 public:
  // `elements`: of the matrix of cross-axis errors, those that the triad has.
  TriadErrorSource(const TriadErrors& errors, const TriadTruth& given, std::span<const ImuErrorElement> elements,
                   std::uint64_t seed, const std::string& name)
      : errors_(errors),
        given_(given),
        drift_(errors.drift, {seed, name + "/drift"}),
        noise_(seed, name + "/noise"),
        quantization_(seed, name + "/quantization") {
    draw.bias = draw_constant(given.bias, given.bias_spread, errors.bias, {seed, name + "/bias"});
    draw.scale = draw_constant(given.scale, given.scale_spread, errors.scale, {seed, name + "/scale"});
    RandomStream tilt(seed, name + "/misalignment");
    Matrix3d drawn;
    for (int i = 0; i < 3; ++i)
      drawn.col(i) = given.misalignment.value_or(errors.cross_axis.value_or(0)) * tilt.normal3();
    draw.misalignment.setIdentity();
    for (const auto& [input, signal] : elements)
      draw.misalignment(input % 3, signal % 3) = drawn(input % 3, signal % 3);
    rounding_ = given.quantization * quantization_.normal3();
    draw.drift_first = drift_.value();
  }

  // Measures the row that ends `since_start` seconds after the start and lasts dt. `other`: what another signal adds.
  Vector3d measure(const Vector3d& truth, const Vector3d& other, double since_start, double dt, Phase phase) {
    Vector3d row = draw.misalignment * truth;
    row += draw.scale.cwiseProduct(row) + other + draw.bias + drift_.advance(dt);
    const Vector3d warm_up = std::exp(-since_start / given_.warm_up_time) * given_.warm_up;
    row += warm_up;
    row += (errors_.densities() / std::sqrt(dt)).cwiseProduct(noise_.normal3());
    if (given_.quantization > 0) {
      const Vector3d now = given_.quantization * quantization_.normal3();
      row += (now - rounding_) / dt;
      rounding_ = now;
    }
    drift_values_.add(drift_.value());
    phases_[phase].drift.add(drift_.value() + warm_up);
    phases_[phase].signal.add(truth);
    return clip(row);
  }

  const Vector3d& drift() const { return drift_.value(); }

  void finish() {
    draw.drift_last = drift_.value();
    draw.drift_mean = drift_values_.mean();
    draw.drift_rms = drift_values_.rms();
    draw.before = draw_of(kBefore);
    draw.run = draw_of(kRun);
    draw.after = draw_of(kAfter);
  }

  TriadDraw draw;

 private:
  PhaseDraw draw_of(Phase phase) const {
    const auto& [drift, signal] = phases_[phase];
    return {signal.count(), drift.mean(), signal.mean(), signal.rms()};
  }
  Vector3d clip(const Vector3d& row) {
    if (errors_.range <= 0) return row;
    if (row.cwiseAbs().maxCoeff() > errors_.range) ++draw.clipped;
    return row.cwiseMax(-errors_.range).cwiseMin(errors_.range);
  }

  TriadErrors errors_;
  TriadTruth given_;
  DriftPath drift_;
  RandomStream noise_, quantization_;
  Vector3d rounding_;
  Moments drift_values_;
  struct {
    Moments drift, signal;
  } phases_[3];
};

// Coloured error at each of these times. Empty if there is none.
std::vector<Vector3d> coloured(const Truth& plate, double rate, const std::optional<GaussMarkov>& process,
                               RandomStream stream) {
  std::vector<Vector3d> values;
  if (!process) return values;
  DriftPath path(*process, stream);
  values.resize(epochs(plate, rate).size());
  for (Vector3d& value : values) {
    value = path.value();
    path.advance(1 / rate);
  }
  return values;
}

Vector3d total_sigma(const Vector3d& white, const std::optional<GaussMarkov>& coloured) {
  return coloured ? Vector3d((white.cwiseAbs2() + coloured->sigma.cwiseAbs2()).cwiseSqrt()) : white;
}

}  // namespace

Vector3d field_in_body(const Truth& body, double time, const Vector3d& field) {
  const TruthState state = body.at(time);
  return state.q_wb.conjugate() * (body.world().rotation_wn(state.p_wb) * field);
}

SimulatedImu simulate_imu(const Truth& plate, const ImuSetup& setup, std::uint64_t seed) {
  const Truth truth = plate.attached(setup.q_rb, setup.p_rb_r);
  const double start = truth.start_time(), step = 1 / setup.rate;
  const std::size_t rows = count_of((truth.end_time() - start) * (1 + setup.clock_drift), setup.rate);
  const auto gps_of = [&](std::size_t k) {
    return start + static_cast<double>(k) * step * (1 - setup.clock_drift) + step;
  };
  TriadErrorSource gyro(setup.sensor.gyro, setup.gyro, elements_of(Block::kGyroCrossAxis), seed, setup.name + "/gyro");
  TriadErrorSource accel(setup.sensor.accel, setup.accel, elements_of(Block::kAccelCrossAxis), seed,
                         setup.name + "/accel");
  RandomStream sensitivity(seed, setup.name + "/g_sensitivity");
  RandomStream magnetic_noise(seed, setup.name + "/magnetic"), iron(seed, setup.name + "/iron");
  DriftPath disturbance(setup.magnetometer.disturbance, {seed, setup.name + "/disturbance"});

  const Interval run = truth.under_way();

  SimulatedImu out;
  for (int i = 0; i < 3; ++i) {
    out.g_sensitivity.row(i) = setup.sensor.gyro_g_sensitivity.value_or(0) * sensitivity.normal3().transpose();
  }
  out.hard_iron = setup.magnetometer.hard_iron * iron.normal3();
  for (int i = 0; i < 3; ++i) out.soft_iron.row(i) = setup.magnetometer.soft_iron * iron.normal3().transpose();
  out.recording.file = setup.name + ".csv";
  out.recording.increments = setup.sampling == ImuSetup::Sampling::kIncrements;
  const double dt = step * (1 - setup.clock_drift);
  for (std::size_t k = 0; k < rows; ++k) {
    check_interruption();
    const double gps = gps_of(k);
    MeanInertial signal;
    if (setup.sampling == ImuSetup::Sampling::kInstant) {
      const TruthState state = truth.at(gps);
      signal = {state.w_ib_b, state.f_ib_b};
    } else {
      signal = truth.mean(gps - dt, gps);
    }
    const Vector3d rate =
        gyro.measure(signal.gyro, out.g_sensitivity * signal.accel, gps - start, dt, phase_of(gps, run));
    const Vector3d force = accel.measure(signal.accel, Vector3d::Zero(), gps - start, dt, phase_of(gps, run));
    const double unit = out.recording.increments ? dt : 1;
    out.recording.time.push_back(start + step + setup.clock_offset + static_cast<double>(k) * step);
    out.recording.gyro.emplace_back(unit * rate);
    out.recording.accel.emplace_back(unit * force);
    if (setup.magnetic_field) {
      out.magnetic_disturbance.push_back(disturbance.advance(dt));
      const Vector3d field = field_in_body(truth, gps, *setup.magnetic_field);
      out.recording.magnetic.emplace_back(field + out.soft_iron * field + out.hard_iron +
                                          field_in_body(truth, gps, disturbance.value()) +
                                          setup.magnetometer.sigma * magnetic_noise.normal3());
    }
    out.signal.push_back(signal);
    out.gps_time.push_back(gps);
    out.gyro_drift.push_back(gyro.drift());
    out.accel_drift.push_back(accel.drift());
  }
  gyro.finish();
  accel.finish();
  out.gyro = gyro.draw;
  out.accel = accel.draw;
  return out;
}

GnssRecording simulate_gnss(const Truth& plate, const GnssSetup& setup, std::uint64_t seed) {
  const World& world = plate.world();
  const Truth antenna = plate.attached(Quaterniond::Identity(), setup.p_ra_r);
  RandomStream position_noise(seed, setup.name + "/position"), velocity_noise(seed, setup.name + "/velocity");
  const std::vector<Vector3d> drift = position_drift(plate, setup, seed);

  GnssRecording out{setup.name + ".csv", {}};
  for (const double time : epochs(plate, setup.rate)) {
    check_interruption();
    const TruthState state = antenna.at(time - setup.delay);
    const Matrix3d R_wn = world.rotation_wn(state.p_wb);
    Vector3d error = setup.position_noise.cwiseProduct(position_noise.normal3());
    if (!drift.empty()) error += drift[out.fixes.size()];
    GeodeticFix fix;
    fix.time = time;
    fix.position = world.to_geodetic(state.p_wb + R_wn * error);
    fix.sigma_position = total_sigma(setup.position_noise, setup.position_drift);
    if (setup.velocity_noise.maxCoeff() > 0) {
      const Vector3d v_error = setup.velocity_noise.cwiseProduct(velocity_noise.normal3());
      const TruthState then = antenna.at(time - setup.delay_of_velocity());
      fix.velocity = {world.rotation_wn(then.p_wb).transpose() * then.v_wb + v_error, setup.velocity_noise};
    }
    out.fixes.push_back(fix);
  }
  return out;
}

std::vector<Vector3d> position_drift(const Truth& plate, const GnssSetup& setup, std::uint64_t seed) {
  return coloured(plate, setup.rate, setup.position_drift, {seed, setup.name + "/position drift"});
}

AttitudeRecording simulate_attitude(const Truth& plate, const AttitudeSetup& setup, std::uint64_t seed) {
  const World& world = plate.world();
  RandomStream noise(seed, setup.name + "/noise");
  const std::vector<Vector3d> drift = attitude_drift(plate, setup, seed);
  const Vector3d sigma = total_sigma(setup.noise, setup.drift);

  AttitudeRecording out{setup.name + ".csv", {}};
  for (const double time : epochs(plate, setup.rate)) {
    check_interruption();
    const TruthState state = plate.at(time - setup.delay);
    const Matrix3d R_nw = world.rotation_wn(state.p_wb).transpose();
    Vector3d error = setup.noise.cwiseProduct(noise.normal3());
    if (!drift.empty()) error += drift[out.fixes.size()];
    const Quaterniond q_nr = Quaterniond(R_nw) * so3_exp(error) * state.q_wb;
    const Matrix3d covariance = R_nw * sigma.cwiseAbs2().asDiagonal() * R_nw.transpose();
    out.fixes.push_back({time, to_euler(q_nr), euler_sigma(q_nr, covariance)});
  }
  return out;
}

std::vector<Vector3d> attitude_drift(const Truth& plate, const AttitudeSetup& setup, std::uint64_t seed) {
  return coloured(plate, setup.rate, setup.drift, {seed, setup.name + "/drift"});
}

}  // namespace piste
