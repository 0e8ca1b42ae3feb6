#include "support/monte_carlo.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "piste/condition/pipeline.h"
#include "piste/condition/rest_detection.h"
#include "piste/math/statistics.h"
#include "piste/sim/random.h"
#include "piste/solve/start.h"

namespace piste::test {
namespace {

template <class Setups>
void keep_only(Setups& setups, const std::string& name) {
  std::erase_if(setups, [&](const auto& s) { return s.name != name; });
}

FilterOptions options_of(const Experiment& e) {
  const GnssSetup& receiver = e.scenario.gnss.front();
  FilterOptions options;
  options.sensor = e.sensor;
  options.gnss.push_back({.name = receiver.name,
                          .lever_arm = lever_arm(e.scenario.imus.front(), receiver),
                          .drift = receiver.position_drift});
  options.estimate = {Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
                      Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};
  if (receiver.position_drift) options.estimate.push_back(Block::kGnssPositionDrift);
  return options;
}

// The truth as the filter would hold it, in the world of the log.
class TrueEstimate {
 public:
  TrueEstimate(const Experiment& e, const Simulation& run, const World& world, std::uint64_t seed)
      : body_(run.bodies.front()), imu_(run.imus.front()), world_(world) {
    // The receiver again without its white noise: what then stands between a fix and the antenna is the drift.
    GnssSetup quiet = e.scenario.gnss.front();
    if (!quiet.position_drift) return;
    quiet.position_noise.setZero();
    const Truth antenna = run.plate.attached(Quaterniond::Identity(), quiet.p_ra_r);
    for (const GeodeticFix& fix : simulate_gnss(run.plate, quiet, seed).fixes) {
      const Geodetic place = body_.world().to_geodetic(antenna.at(fix.time).p_wb);
      gnss_.push_back({fix.time, world_.from_geodetic(fix.position) - world_.from_geodetic(place)});
    }
  }

  Estimate at(double time) const {
    const TruthState truth = body_.at(time);
    const World& simulated = body_.world();
    Estimate x;
    x.p_wb = world_.from_geodetic(simulated.to_geodetic(truth.p_wb));
    const Quaterniond turn(world_.rotation_wn(x.p_wb) * simulated.rotation_wn(truth.p_wb).transpose());
    x.q_wb = (turn * truth.q_wb).normalized();
    x.v_wb = turn * truth.v_wb;
    x.gyro_bias = imu_.gyro.bias;
    x.accel_bias = imu_.accel.bias;
    x.gyro_scale = imu_.gyro.scale;
    x.accel_scale = imu_.accel.scale;
    const auto row = nearest(imu_.gps_time, time, [](double t) { return t; });
    x.gyro_drift = imu_.gyro_drift[row];
    x.accel_drift = imu_.accel_drift[row];
    if (!gnss_.empty()) x.gnss_position_drift = gnss_[nearest(gnss_, time, [](const auto& d) { return d.time; })].value;
    return x;
  }

 private:
  struct Drift {
    double time;
    Vector3d value;
  };

  template <class Samples, class Time>
  static std::size_t nearest(const Samples& samples, double time, Time&& of) {
    auto after = std::partition_point(samples.begin(), samples.end(), [&](const auto& s) { return of(s) < time; });
    if (after == samples.end() || (after != samples.begin() && time - of(*(after - 1)) < of(*after) - time)) --after;
    return static_cast<std::size_t>(after - samples.begin());
  }

  const Truth& body_;
  const SimulatedImu& imu_;
  const World& world_;
  std::vector<Drift> gnss_;
};

// truth = start ⊞ error with error of N(0, P): the biases and drifts are drawn by the simulator already.
Start drawn_start(const Estimate& truth, double time, const Vector3d& lever_arm, std::uint64_t seed) {
  constexpr double kDegree = 1 / kDegreesPerRadian;
  Eigen::Matrix<double, 9, 1> sigma;
  // Attitude as find_start leaves it. From a tilt of 1 deg and a heading of 3 deg what is linear no longer holds at
  // rest: an error of 3 deg turns an accelerometer bias of 50 mm/s² by 2.6 mm/s², which a rest would have told.
  sigma << Vector3d::Constant(0.5), Vector3d::Constant(0.05), Vector3d(kDegree / 3, kDegree / 3, kDegree);
  RandomStream random(seed, "start");
  FullError error = FullError::Zero();
  for (int i = 0; i < 9; ++i) error(i) = -sigma(i) * random.normal();
  Estimate x;
  x.q_wb = truth.q_wb;
  x.v_wb = truth.v_wb;
  x.p_wb = truth.p_wb;
  x.lever_arm = lever_arm;
  return {time, boxplus(x, error), sigma.cwiseAbs2().asDiagonal()};
}

}  // namespace

Experiment experiment(const std::string& name, const std::string& receiver, double rest_before, double run,
                      double rest_after) {
  Experiment e{.scenario = read_scenario(std::string(PISTE_SOURCE_DIR "/config/scenarios/") + name + ".yaml"),
               .sensor = {}};
  keep_only(e.scenario.imus, e.scenario.imus.front().name);
  keep_only(e.scenario.gnss, receiver);
  e.scenario.attitude.clear();
  MotionOptions& motion = e.scenario.motion;
  motion.net_turn *= run / motion.run;
  motion.rest_before = rest_before;
  motion.run = run;
  motion.rest_after = rest_after;
  e.sensor = e.scenario.imus.front().sensor;
  return e;
}

ReplayedRun replay(const Experiment& e, std::uint64_t seed) {
  const Simulation run = simulate(e.scenario, seed);
  const ImuSetup& setup = e.scenario.imus.front();
  const FilterOptions options = options_of(e);
  ConditioningOptions conditioning;
  conditioning.imu.clock_offset = setup.clock_offset;
  conditioning.imu.clock_drift = setup.clock_drift;
  conditioning.imu.instantaneous = setup.sampling == ImuSetup::Sampling::kInstant;
  conditioning.gyro_range = e.sensor.gyro.range;
  conditioning.accel_range = e.sensor.accel.range;
  conditioning.rest = options.rest;
  Log log = condition(run.recording(0), conditioning);
  mark_rest(log, options.rest);

  const TrueEstimate truth(e, run, log.world, seed);
  const double begin = log.imu.front().time - log.imu.front().interval;
  const Start start = e.find_heading ? find_start(log, options, {}).start
                                     : drawn_start(truth.at(begin), begin, options.gnss.front().lever_arm, seed);
  const FilterRun filtered = run_filter(log, options, start, kCheckpointEvery);

  ReplayedRun out{filtered.solution.layout(), {}, {}};
  const double run_begin = run.plate.under_way().start;
  const auto sample = [&](double time, const Estimate& x, const Covariance& P) {
    const FullError full = boxminus(truth.at(time), x);
    ErrorSample s{time - run_begin, ErrorVector(out.layout.size()), P};
    for (const Block b : out.layout.blocks()) {
      s.error.segment(out.layout.offset(b), info(b).size) = full.segment(full_offset(b), info(b).size);
    }
    return s;
  };
  const double rate = setup.rate;
  const auto stride = static_cast<std::size_t>(std::lround(e.every * rate));
  const auto phase = static_cast<std::size_t>(std::lround((run_begin - begin) * rate)) % stride;
  smooth_rts(log, filtered, {}, nullptr,
             [&](std::size_t row, const Tape::Epoch& before, const SmoothedState& smoothed) {
               if ((row + 1) % stride != phase) return;
               out.filtered.push_back(sample(before.time, before.x, before.P));
               out.smoothed.push_back(sample(before.time, smoothed.x, smoothed.P));
             });
  std::reverse(out.filtered.begin(), out.filtered.end());
  std::reverse(out.smoothed.begin(), out.smoothed.end());
  return out;
}

std::vector<ReplayedRun> replay_all(const Experiment& e, int runs) {
  std::vector<ReplayedRun> out(static_cast<std::size_t>(runs));
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < out.size(); i = next++) out[i] = replay(e, i + 1);
  };
  std::vector<std::jthread> others;
  for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) others.emplace_back(work);
  work();
  others.clear();
  return out;
}

Consistency consistency(const std::vector<ReplayedRun>& runs, bool smoothed, std::span<const Block> blocks, double from,
                        double to, double probability) {
  const StateLayout& layout = runs.front().layout;
  std::vector<int> rows;
  for (const Block b : blocks) {
    for (int i = 0; layout.has(b) && i < info(b).size; ++i) rows.push_back(layout.offset(b) + i);
  }
  double sum = 0, samples = 0, beyond = 0;
  for (const ReplayedRun& run : runs) {
    for (const ErrorSample& s : smoothed ? run.smoothed : run.filtered) {
      if (s.time < from || s.time > to) continue;
      const Eigen::VectorXd e = s.error(rows);
      const Eigen::MatrixXd P = s.P(rows, rows);
      // Scaled to correlations: the blocks' units differ by many orders.
      const Eigen::VectorXd scale = P.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::VectorXd z = scale.cwiseProduct(e);
      sum += z.dot((scale.asDiagonal() * P * scale.asDiagonal()).eval().ldlt().solve(z));
      beyond += static_cast<double>((z.array().abs() > 3).count());
      ++samples;
    }
  }
  const auto dof = static_cast<double>(rows.size()), total = dof * static_cast<double>(runs.size());
  const double tail = (1 - probability) / 2;
  return {.dof = static_cast<int>(rows.size()),
          .mean = sum / (samples * dof),
          .low = chi_squared_quantile(tail, total) / total,
          .high = chi_squared_quantile(1 - tail, total) / total,
          .beyond = beyond / (samples * dof)};
}

}  // namespace piste::test
