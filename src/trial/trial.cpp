#include "piste/trial/trial.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/time_search.h"
#include "filter/considered.h"
#include "piste/condition/pipeline.h"
#include "piste/condition/rest_detection.h"
#include "piste/core/error.h"
#include "piste/replay/replay.h"
#include "piste/sim/random.h"
#include "piste/smoother/rts.h"
#include "piste/start/attitude_noise.h"
#include "piste/start/initial_stretch.h"
#include "smoother/relinearise.h"
#include "start/heading_search.h"
#include "trial/true_estimate.h"
#include "walker/fix_queue.h"

namespace piste {
namespace {

// The scenario with only the sensors that its replay uses.
Scenario carried(const Scenario& scenario, std::uint64_t seed) {
  Scenario s = scenario;
  const ReplaySetup& replay = scenario.replay;
  s.imus = {scenario.imus[replay.imu]};
  for (const std::size_t i : replay.further) s.imus.push_back(scenario.imus[i]);
  s.gnss.clear();
  for (const std::size_t i : replay.gnss) s.gnss.push_back(scenario.gnss[i]);
  s.attitude.clear();
  for (const std::size_t i : replay.attitude) s.attitude.push_back(scenario.attitude[i]);
  if (replay.random_headings) s.motion.heading = 2 * std::numbers::pi * RandomStream(seed, "heading").uniform();
  return s;
}

// The same receivers and references without an error.
Scenario perfect(Scenario s) {
  for (GnssSetup& receiver : s.gnss) {
    receiver.position_noise.setZero();
    receiver.position_drift.reset();
    receiver.velocity_noise *= 1e-9;  // zero would mean a receiver without velocity
  }
  for (AttitudeSetup& reference : s.attitude) {
    reference.noise.setZero();
    reference.drift.reset();
  }
  return s;
}

// The same motion and times with sensors without errors. They still clip, and state the same sigmas.
Simulation perfect(const Scenario& ideal, const Simulation& real, std::uint64_t seed) {
  Simulation out = real;
  const auto clipped = [](const Vector3d& value, double range) {
    return range > 0 ? Vector3d(value.cwiseMax(-range).cwiseMin(range)) : value;
  };
  for (std::size_t i = 0; i < out.imus.size(); ++i) {
    const ImuSetup& setup = ideal.imus[i];
    SimulatedImu& imu = out.imus[i];
    imu.gyro.bias = imu.gyro.scale = imu.accel.bias = imu.accel.scale = Vector3d::Zero();
    for (std::size_t k = 0; k < imu.signal.size(); ++k) {
      const double unit = imu.recording.increments ? (1 - setup.clock_drift) / setup.rate : 1;
      imu.recording.gyro[k] = unit * clipped(imu.signal[k].gyro, setup.sensor.gyro.range);
      imu.recording.accel[k] = unit * clipped(imu.signal[k].accel, setup.sensor.accel.range);
      imu.gyro_drift[k] = imu.accel_drift[k] = Vector3d::Zero();
      if (!setup.magnetic_field) continue;
      imu.recording.magnetic[k] = field_in_body(real.bodies[i], imu.gps_time[k], *setup.magnetic_field);
      imu.magnetic_disturbance[k].setZero();
    }
    imu.hard_iron.setZero();
    imu.soft_iron.setZero();
  }
  for (std::size_t r = 0; r < out.gnss.size(); ++r) {
    out.gnss[r] = simulate_gnss(real.plate, ideal.gnss[r], seed);
    for (std::size_t k = 0; k < out.gnss[r].fixes.size(); ++k) {
      GeodeticFix& fix = out.gnss[r].fixes[k];
      const GeodeticFix& seen = real.gnss[r].fixes[k];
      fix.sigma_position = seen.sigma_position;
      if (fix.velocity) fix.velocity->sigma = seen.velocity->sigma;
    }
  }
  out.aids = simulate_aids(real.trunk, real.plate, ideal.aids, seed, true);
  for (std::size_t r = 0; r < out.attitude.size(); ++r) {
    out.attitude[r] = simulate_attitude(real.plate, ideal.attitude[r], seed);
    for (std::size_t k = 0; k < out.attitude[r].fixes.size(); ++k) {
      out.attitude[r].fixes[k].sigma = real.attitude[r].fixes[k].sigma;
    }
  }
  return out;
}

// Errors of the configured delays: configured minus true.
struct DelayErrors {
  double position = 0, velocity = 0, attitude = 0;  // s
};

void configure_delays(const Scenario& s, const DelayErrors& errors, FilterOptions& options) {
  for (std::size_t i = 0; i < s.gnss.size(); ++i) {
    options.gnss[i].delay = s.gnss[i].delay + errors.position;
    options.gnss[i].velocity_delay = s.gnss[i].delay_of_velocity() + errors.velocity;
  }
  for (std::size_t i = 0; i < s.attitude.size(); ++i) options.attitude[i].delay = s.attitude[i].delay + errors.attitude;
}

// Errors of the estimated delays, drawn with the sigma of the prior. All receivers share one error, because the
// estimated delay is common to them.
DelayErrors drawn_delays(const FilterOptions& options, std::uint64_t seed) {
  const StateLayout layout(options.estimate);
  const auto error = [&](Block block, double prior) {
    return layout.has(block) ? prior * RandomStream(seed, info(block).name).normal() : 0;
  };
  DelayErrors errors{.position = error(Block::kGnssDelay, options.priors.gnss_delay),
                     .attitude = error(Block::kAttitudeDelay, options.priors.attitude_delay)};
  errors.velocity =
      layout.has(Block::kVelocityDelay) ? error(Block::kVelocityDelay, options.priors.velocity_delay) : errors.position;
  return errors;
}

// Error of the configured drift of the IMU's clock, configured minus true, drawn likewise if the drift is estimated.
double drawn_clock_drift(const FilterOptions& options, std::uint64_t seed) {
  const Block drift = Block::kClockDrift;
  if (!StateLayout(options.estimate).has(drift)) return 0;
  return options.priors.clock_drift * RandomStream(seed, info(drift).name).normal();
}

// Draws the configured mounting and contact point of the vehicle about the truth, with the sigmas of the priors.
void draw_mounting(VehicleOptions& vehicle, std::uint64_t seed) {
  RandomStream random(seed, "vehicle");
  vehicle.mounting = so3_exp(vehicle.mounting_sigma.cwiseProduct(random.normal3())) * *vehicle.mounting;
  vehicle.contact += vehicle.contact_sigma.cwiseProduct(random.normal3());
}

ImuConditioning conditioning_of(const ImuSetup& imu, const ImuSetup& first) {
  return {.R_bs = (first.q_rb.conjugate() * imu.q_rb).toRotationMatrix(),
          .instantaneous = imu.sampling == ImuSetup::Sampling::kInstant,
          .clock_offset = imu.clock_offset,
          .clock_drift = imu.clock_drift};
}

// Estimated lever arms start at values drawn about the truth with the sigma of the prior.
FilterOptions filter_options(const Scenario& s, std::uint64_t seed) {
  FilterOptions options;
  options.sensor = s.replay.sensor;
  options.imus = s.replay.imus;
  if (!options.imus.empty()) {
    for (const ImuSetup& imu : s.imus) options.unit_axes.push_back(conditioning_of(imu, s.imus.front()).R_bs);
  }
  options.estimate = s.replay.estimate;
  options.adapt = s.replay.adapt;
  set_aids(options, s, s.imus.front());
  if (options.vehicle) draw_mounting(*options.vehicle, seed);
  for (const GnssSetup& receiver : s.gnss) {
    options.gnss.push_back({.name = receiver.name,
                            .lever_arm = lever_arm(s.imus.front(), receiver),
                            .use_velocity = receiver.velocity_noise.maxCoeff() > 0,
                            .drift = receiver.position_drift});
  }
  if (StateLayout(options.estimate).has(Block::kLeverArm)) {
    for (GnssOptions& receiver : options.gnss) {
      receiver.lever_arm += options.priors.lever_arm * RandomStream(seed, receiver.name + "/lever arm").normal3();
    }
  }
  for (const AttitudeSetup& reference : s.attitude) {
    options.attitude.push_back({.name = reference.name, .drift = reference.drift});
  }
  configure_delays(s, drawn_delays(options, seed), options);
  return options;
}

// `units`: the configured sensor of each of several IMUs.
ConditioningOptions conditioning_options(const Scenario& s, const ImuSensor& sensor, const std::vector<ImuSensor>& imus,
                                         double departure) {
  const ImuSetup& first = s.imus.front();
  ConditioningOptions options;
  options.imu = conditioning_of(first, first);
  options.imu.R_bs.setIdentity();
  for (std::size_t i = 0; i < imus.size(); ++i) {
    const ImuSetup& imu = s.imus[i];
    options.imus.push_back({.name = imu.name,
                            .imu = conditioning_of(imu, first),
                            .sensor = imus[i],
                            .place = first.q_rb.conjugate() * (imu.p_rb_r - first.p_rb_r)});
  }
  options.magnetic = {.field = first.magnetic_field, .interval = kMagneticInterval};
  options.gyro_range = sensor.gyro.range;
  options.accel_range = sensor.accel.range;
  options.span = {departure - s.motion.rest_before, departure + s.replay.end};
  for (const Interval& outage : s.replay.outages) {
    options.outages.push_back({departure + outage.start, departure + outage.end});
  }
  return options;
}

// Of all IMUs.
Recording recording_of(const Simulation& simulation) {
  Recording out = simulation.recording(0);
  for (std::size_t i = 1; i < simulation.imus.size(); ++i) out.further.push_back(simulation.imus[i].recording);
  return out;
}

// truth = start ⊞ error with error of N(0, P). The simulator has drawn the errors of the sensors already.
Start drawn_start(const Scenario& s, const FilterOptions& options, const Estimate& truth, double time,
                  std::uint64_t seed) {
  const StartSigmas& sigmas = s.replay.start;
  Eigen::Matrix<double, 9, 1> sigma;
  sigma << Vector3d::Constant(sigmas.position), Vector3d::Constant(sigmas.velocity), sigmas.tilt, sigmas.tilt,
      sigmas.heading;
  RandomStream random(seed, "start");
  FullError error = FullError::Zero();
  for (int i = 0; i < 9; ++i) error(i) = -sigma(i) * random.normal();
  Estimate x;
  x.q_wb = truth.q_wb;
  x.v_wb = truth.v_wb;
  x.p_wb = truth.p_wb;
  x.lever_arm = options.gnss.front().lever_arm;
  set_known(x, options);
  return {time, boxplus(x, error), sigma.cwiseAbs2().asDiagonal()};
}

// The prior if the heading must be estimated: only position and velocity are roughly known.
Covariance nothing_known() {
  constexpr double kPosition = 10, kVelocity = 10, kTilt = 0.2;
  Eigen::Matrix<double, 9, 1> sigma;
  sigma << Vector3d::Constant(kPosition), Vector3d::Constant(kVelocity), kTilt, kTilt, kUnknownHeading;
  return sigma.cwiseAbs2().asDiagonal();
}

// The matrix from the filter's error to the ordinary error along the local level, for all blocks of the layout.
Covariance ordinary(const World& world, const StateLayout& layout, const Estimate& x) {
  Covariance T = Covariance::Identity(layout.size(), layout.size());
  T.topLeftCorner<9, 9>() = level_from_invariant(world.rotation_wn(x.p_wb), x);
  return T;
}

// The epochs of the grid, each at the index of its nearest row.
std::map<std::size_t, int> rows_on(const Solution& solution, const EpochGrid& grid, double departure) {
  std::map<std::size_t, int> epochs;
  for (std::size_t row = 0; row < solution.size(); ++row) {
    const double time = solution.time(row) - departure;
    const int epoch = static_cast<int>(std::lround(time / grid.step));
    if (epoch < grid.first || epoch > grid.last) continue;
    const auto before = epochs.empty() ? epochs.end() : std::prev(epochs.end());
    const double off = std::abs(time - grid.time(epoch));
    if (before == epochs.end() || before->second != epoch) {
      epochs.emplace(row, epoch);
    } else if (off < std::abs(solution.time(before->first) - departure - grid.time(epoch))) {
      epochs.erase(before);
      epochs.emplace(row, epoch);
    }
  }
  return epochs;
}

// Calls `visit(epoch, filtered, smoothed)` for these epochs, the last one first.
template <class Visit>
void visit_rows(const FilterRun& run, const std::map<std::size_t, int>& epochs, Visit&& visit) {
  std::vector<std::size_t> rows;
  rows.reserve(epochs.size());
  for (const auto& [row, epoch] : epochs) rows.push_back(row);
  smooth_rows(run, rows, [&](std::size_t row, const FilterState& filtered, const SmoothedState& smoothed) {
    visit(epochs.at(row), filtered, smoothed);
  });
}

// The rows among the first `count` rows.
std::map<std::size_t, int> first_rows(const std::map<std::size_t, int>& rows, std::size_t count) {
  return {rows.begin(), rows.lower_bound(count)};
}

// Maps the epochs of these rows of `from` to rows of `to`, which has fewer rows at standstill.
std::map<std::size_t, int> rows_of(const Solution& to, const Solution& from, const std::map<std::size_t, int>& rows) {
  std::map<std::size_t, int> out;
  std::size_t next = 0;
  for (const auto& [row, epoch] : rows) {
    while (next + 1 < to.size() && to.time(next) < from.time(row) - kSameInstant) ++next;
    out.emplace(next, epoch);
  }
  return out;
}

struct Bound {
  ErrorVector filtered, smoothed;
};

// Variances of the bound at the epochs of the grid. The white part of a reference attitude is taken from the real log,
// because perfect fixes do not determine it.
std::map<int, Bound> bound_of(const Scenario& scenario, const Simulation& real, const Replay& run, std::uint64_t seed,
                              const EpochGrid& grid) {
  const Scenario ideal = perfect(scenario);
  const Simulation simulation = perfect(ideal, real, seed);
  FilterOptions options = run.options;
  options.sensor = scenario.imus.front().sensor;  // the true sensor, which the filter may not know
  if (!options.imus.empty()) {
    options.imus.clear();
    for (const ImuSetup& imu : scenario.imus) options.imus.push_back(imu.sensor);
    options.sensor = mean_sensor(options.imus);
  }
  options.adapt.reset();  // there is no noise to adapt to
  configure_delays(scenario, {}, options);
  const double departure = simulation.plate.under_way().start;
  ConditioningOptions conditioning = conditioning_options(scenario, options.sensor, options.imus, departure);
  conditioning.behaviour.rest.detect = false;
  const Log log = with_rest(condition(recording_of(simulation), conditioning), run.log.rest);

  const TrueEstimate truth(ideal, simulation, log.world, seed, options.imus);
  const Start& start = run.found.start;
  Start from{start.time, truth.at(start.time), start.covariance};
  if (scenario.replay.heading == ReplaySetup::Heading::kAuto) from.covariance = nothing_known();
  const FilterRun perfect_run = run_filter(log, options, from, Keep::kHistory);
  std::map<int, Bound> out;
  const StateLayout& layout = perfect_run.solution.layout();
  const std::map<std::size_t, int> rows = rows_on(perfect_run.solution, grid, departure);
  const auto variance = [&](const Estimate& x, const Covariance& P) -> ErrorVector {
    const Covariance T = ordinary(log.world, layout, x);
    return (T * restricted(P, filter_layout(options), layout) * T.transpose()).diagonal();
  };
  visit_rows(perfect_run, rows, [&](int epoch, const FilterState& filtered, const SmoothedState& smoothed) {
    out[epoch] = {variance(filtered.x, filtered.P), variance(filtered.x, smoothed.P)};
  });
  if (!run.found.aligned) return out;
  // Rows before the heading was known are back-smoothed from the end of this initial stretch.
  const FilterRun beginning =
      run_filter(log, options, from, Keep::kHistory, {}, {.end = *run.found.aligned + kSameInstant});
  visit_rows(beginning, first_rows(rows, beginning.epochs),
             [&](int epoch, const FilterState& filtered, const SmoothedState& smoothed) {
               out[epoch].filtered = variance(filtered.x, smoothed.P);
             });
  return out;
}

}  // namespace

EpochGrid epoch_grid(const Scenario& s) {
  const MotionOptions& m = s.motion;
  const double step = s.replay.every;
  return {.step = step,
          .first = -static_cast<int>(m.rest_before / step),
          .last = static_cast<int>(s.replay.end / step),
          .cruise = {std::min(m.start_time, s.replay.end), std::min(m.run - m.stop_time, s.replay.end)},
          .arrival = m.run};
}

ComparedRun run_trial(const Scenario& scenario, std::uint64_t seed, const BatchSolver& batch) {
  const bool by_batch = scenario.replay.smoother == SmootherKind::kBatch;
  if (by_batch && !batch) {
    throw ConfigError("smoother", "batch needs piste::batch, with which this program was not linked; choose rts");
  }
  const Scenario s = carried(scenario, seed);
  const Simulation simulation = simulate(s, seed);
  const double departure = simulation.plate.under_way().start;
  const Recording recording = recording_of(simulation);
  ReplayOptions options{.filter = with_attitude_sigmas(filter_options(s, seed), recording.attitude),
                        .smoother = SmootherKind::kNone};
  ConditioningOptions conditioning = conditioning_options(s, options.filter.sensor, options.filter.imus, departure);
  const double clock_error = drawn_clock_drift(options.filter, seed);
  conditioning.imu.clock_drift += clock_error;
  for (FusedImuConditioning& unit : conditioning.imus) unit.imu.clock_drift += clock_error;
  options.filter.clock_from = recording.imu.time.front() - conditioning.imu.clock_offset;
  Log log = condition(recording, conditioning);

  TrueEstimate truth(s, simulation, log.world, seed, options.filter.imus);
  truth.set_clock(-clock_error, *options.filter.clock_from);
  if (s.replay.heading == ReplaySetup::Heading::kKnown) {
    const double begin = log.imu.front().time - log.imu.front().interval;
    options.start = drawn_start(s, options.filter, truth.at(begin), begin, seed);
  }
  const Replay run = replay(std::move(log), options);

  const EpochGrid grid = epoch_grid(s);
  const std::map<int, Bound> bound = bound_of(s, simulation, run, seed, grid);
  const Solution& filtered = run.filtered.solution;
  ComparedRun out{.seed = seed,
                  .layout = filtered.layout(),
                  .filtered = {},
                  .smoothed = {},
                  .sources = filtered.sources,
                  .innovations = filtered.innovations};
  for (Innovation& v : out.innovations) v.time -= departure;
  const StateLayout all = filter_layout(run.options);
  const auto sample = [&](int epoch, double time, const Estimate& x, const Covariance& P, const ErrorVector& variance) {
    const ErrorVector error = select(out.layout, boxminus(truth.at(time), x));
    const Covariance T = ordinary(run.log.world, out.layout, x);
    return ErrorSample{epoch, T * error, T * restricted(P, all, out.layout) * T.transpose(), variance};
  };
  const std::map<std::size_t, int> rows = rows_on(filtered, grid, departure);
  // As replay writes them: rows before the heading was known come from back-smoothing.
  const InitialStretch& stretch = run.stretch;
  const std::size_t replaced = stretch.rows_of(filtered);
  const std::map<std::size_t, int> first = rows_of(stretch.rows, filtered, first_rows(rows, replaced)),
                                   later(rows.lower_bound(replaced), rows.end());
  if (!later.empty()) {
    visit_rows(run.filtered, later, [&](int epoch, const FilterState& before, const SmoothedState&) {
      out.filtered.push_back(sample(epoch, before.time, before.x, before.P, bound.at(epoch).filtered));
    });
  }
  if (!first.empty()) {
    visit_rows(stretch.run, first, [&](int epoch, const FilterState& before, const SmoothedState& smoothed) {
      out.filtered.push_back(sample(epoch, before.time, smoothed.x, smoothed.P, bound.at(epoch).filtered));
    });
  }
  if (by_batch) {
    std::vector<std::size_t> asked;
    asked.reserve(rows.size());
    for (const auto& [row, epoch] : rows) asked.push_back(row);
    const auto states = batch(run.log, run.options, run.found, run.filtered, {})->states(asked);
    for (std::size_t i = asked.size(); i-- > 0;) {
      const int epoch = rows.at(asked[i]);
      out.smoothed.push_back(
          sample(epoch, filtered.time(asked[i]), states[i].x, states[i].P, bound.at(epoch).smoothed));
    }
    return out;
  }
  const FilterRun again = relinearised(run.log, run.options, without_alignment(run.log.world, run.found), run.filtered);
  visit_rows(again, rows, [&](int epoch, const FilterState& before, const SmoothedState& smoothed) {
    out.smoothed.push_back(sample(epoch, before.time, smoothed.x, smoothed.P, bound.at(epoch).smoothed));
  });
  return out;
}

}  // namespace piste
