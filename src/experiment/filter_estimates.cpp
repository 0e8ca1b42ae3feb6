#include "piste/experiment/filter_estimates.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "piste/core/error.h"
#include "piste/solve/attitude_noise.h"
#include "piste/solve/rts.h"
#include "piste/solve/start.h"

namespace piste {
namespace {

using Kind = DriftProcess::Kind;
constexpr double kManyRuns = 100;

struct Model {
  Kind drift;
  bool attitude;
  Method filtered, smoothed;
};

constexpr std::array kModels{
    Model{Kind::kNone, false, Method::kConstantFiltered, Method::kConstantSmoothed},
    Model{Kind::kRandomWalk, false, Method::kWalkFiltered, Method::kWalkSmoothed},
    Model{Kind::kGaussMarkov, false, Method::kMarkovFiltered, Method::kMarkovSmoothed},
    Model{Kind::kNone, true, Method::kConstantAttitudeFiltered, Method::kConstantAttitudeSmoothed},
    Model{Kind::kRandomWalk, true, Method::kWalkAttitudeFiltered, Method::kWalkAttitudeSmoothed},
    Model{Kind::kGaussMarkov, true, Method::kMarkovAttitudeFiltered, Method::kMarkovAttitudeSmoothed},
};

// The process of that kind which moves as fast as `given`.
DriftProcess as(const DriftProcess& given, Kind kind, double run) {
  if (given.kind == Kind::kNone || given.kind == kind) return given;
  if (kind == Kind::kRandomWalk) {
    return {.kind = kind, .density = given.sigma * std::sqrt(2 / given.correlation_time)};
  }
  if (kind == Kind::kNone) return {};
  const double time = kManyRuns * run;
  return {.kind = kind, .sigma = given.density * std::sqrt(time / 2), .correlation_time = time};
}

FilterOptions options_of(const FilterCase& of, const Model& model) {
  FilterOptions options = of.options;
  ImuSensor& sensor = options.sensor;
  const double length = of.run.end - of.run.start;
  sensor.gyro.drift = as(sensor.gyro.drift, model.drift, length);
  sensor.accel.drift = as(sensor.accel.drift, model.drift, length);
  options.estimate = imu_error_blocks(sensor);
  const auto add = [&](Block block, bool wanted) {
    if (wanted) options.estimate.push_back(block);
  };
  for (const GnssOptions& receiver : options.gnss) add(Block::kGnssPositionDrift, receiver.drift.has_value());
  if (model.attitude) {
    options.estimate.push_back(Block::kBoresight);
    add(Block::kAttitudeDrift, options.attitude.front().drift.has_value());
  } else {
    options.attitude.clear();
  }
  return options;
}

Term term(double value, double sigma) {
  constexpr double kKnown = 1e6;  // degrees of freedom of a filter's sigma, which is no estimate
  return {value, sigma, sigma, kKnown};
}

MethodEstimate mean_over(const Solution& solution, const Interval& run, Method method) {
  Eigen::Matrix<double, kSignals, 4> sum = Eigen::Matrix<double, kSignals, 4>::Zero();  // bias, scale, their sigmas
  double epochs = 0;
  for (std::size_t i = 0; i < solution.size(); ++i) {
    if (!run.contains(solution.time(i))) continue;
    const Estimate x = solution.estimate(i);
    const Sigmas s = solution.sigmas(i);
    Eigen::Matrix<double, kSignals, 4> row;
    row.topRows<3>() << x.accel_bias + x.accel_drift, x.accel_scale, s.accel_total_bias,
        s.blocks.segment<3>(full_offset(Block::kAccelScale));
    row.bottomRows<3>() << x.gyro_bias + x.gyro_drift, x.gyro_scale, s.gyro_total_bias,
        s.blocks.segment<3>(full_offset(Block::kGyroScale));
    sum += row;
    epochs += 1;
  }
  if (epochs == 0) throw DataError("", "the filter has no epoch in the run");
  sum /= epochs;
  MethodEstimate out{method, {}};
  const StateLayout& layout = solution.layout();
  for (int axis = 0; axis < kSignals; ++axis) {
    AxisEstimate& estimate = out.axes[static_cast<std::size_t>(axis)];
    const bool force = axis < 3;
    if (!layout.has(force ? Block::kAccelBias : Block::kGyroBias)) continue;
    if (!layout.has(force ? Block::kAccelScale : Block::kGyroScale)) {
      estimate.bias_alone = term(sum(axis, 0), sum(axis, 2));
      continue;
    }
    BiasScale line;
    line.value = sum.row(axis).head<2>();
    line.covariance = line.hac_covariance = sum.row(axis).tail<2>().cwiseAbs2().asDiagonal();
    line.dof = term(0, 0).dof;
    estimate.line = line;
  }
  return out;
}

}  // namespace

std::vector<MethodEstimate> filter_estimates(const FilterCase& of, std::vector<std::string>& warnings) {
  std::vector<MethodEstimate> out;
  Log without = of.log;
  without.attitude.clear();
  for (const Model& model : kModels) {
    if (model.attitude && of.options.attitude.empty()) continue;
    const Log& log = model.attitude ? of.log : without;
    FilterOptions options = options_of(of, model);
    try {
      measure_white_part(log, options);
      using Source = InitialHeading::Source;
      const Start start =
          find_start(log, options, {.source = model.attitude ? Source::kAttitude : Source::kAuto}).start;
      const FilterRun run = run_filter(log, options, start, kCheckpointEvery);
      out.push_back(mean_over(run.solution, of.run, model.filtered));
      out.push_back(mean_over(smooth_rts(log, run), of.run, model.smoothed));
    } catch (const DataError& e) {
      warnings.push_back(fmt::format("{} and its smoother: {}", info(model.filtered).title, e.what()));
    }
  }
  return out;
}

}  // namespace piste
