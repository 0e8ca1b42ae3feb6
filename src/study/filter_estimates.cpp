#include "study/filter_estimates.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "piste/core/error.h"
#include "piste/replay/replay.h"
#include "piste/smoother/rts.h"
#include "smoother/relinearise.h"

namespace piste {
namespace {

using DriftKind = DriftProcess::Kind;
constexpr double kManyRuns = 100;

struct Model {
  DriftKind drift;
  bool attitude;
  Method filtered, smoothed;
};

constexpr std::array kModels{
    Model{DriftKind::kNone, false, Method::kConstantFiltered, Method::kConstantSmoothed},
    Model{DriftKind::kRandomWalk, false, Method::kWalkFiltered, Method::kWalkSmoothed},
    Model{DriftKind::kGaussMarkov, false, Method::kMarkovFiltered, Method::kMarkovSmoothed},
    Model{DriftKind::kNone, true, Method::kConstantAttitudeFiltered, Method::kConstantAttitudeSmoothed},
    Model{DriftKind::kRandomWalk, true, Method::kWalkAttitudeFiltered, Method::kWalkAttitudeSmoothed},
    Model{DriftKind::kGaussMarkov, true, Method::kMarkovAttitudeFiltered, Method::kMarkovAttitudeSmoothed},
};

// A process of the kind `kind` that changes as fast as `given`.
DriftProcess as(const DriftProcess& given, DriftKind kind, double run) {
  if (given.kind == DriftKind::kNone || given.kind == kind) return given;
  if (kind == DriftKind::kRandomWalk) {
    return {.kind = kind, .density = given.sigma * std::sqrt(2 / given.correlation_time)};
  }
  if (kind == DriftKind::kNone) return {};
  const double time = kManyRuns * run;
  return {.kind = kind, .sigma = given.density * std::sqrt(time / 2), .correlation_time = time};
}

FilterOptions options_of(const FilterCase& of, const Model& model) {
  FilterOptions options = of.options;
  ImuSensor& sensor = options.sensor;
  const double length = of.run.end - of.run.start;
  const auto change = [&](ImuSensor& s) {
    s.gyro.drift = as(s.gyro.drift, model.drift, length);
    s.accel.drift = as(s.accel.drift, model.drift, length);
  };
  change(sensor);
  for (ImuSensor& unit : options.imus) change(unit);
  options.estimate = imu_error_blocks(sensor);
  const auto add = [&](Block block, bool wanted) {
    if (wanted) options.estimate.push_back(block);
  };
  for (const Block block : position_drifts(options)) add(block, true);
  if (model.attitude) {
    options.estimate.push_back(Block::kBoresight);
    add(Block::kAttitudeDrift, options.attitude.front().drift.has_value());
  } else {
    options.attitude.clear();
  }
  if (!options.imus.empty()) options.estimate = with_implied_blocks(options, std::move(options.estimate));
  return options;
}

constexpr double kKnown = 1e6;  // degrees of freedom of a filter's sigma, which is computed and not estimated

// Means over epochs of bias + drift and of scale, and of their covariance.
class Mean {
 public:
  explicit Mean(StateLayout layout) : layout_(std::move(layout)) {}

  void add(const Estimate& x, const Covariance& P) {
    for (int axis = 0; axis < kSignals; ++axis) {
      BiasScale& line = lines_[static_cast<std::size_t>(axis)];
      const bool force = axis < 3;
      const int i = axis % 3;
      line.value(0) += force ? x.accel_bias(i) + x.accel_drift(i) : x.gyro_bias(i) + x.gyro_drift(i);
      line.value(1) += force ? x.accel_scale(i) : x.gyro_scale(i);
      const Eigen::Matrix<double, 2, Eigen::Dynamic> T = selection(axis);
      line.covariance += T * P * T.transpose();
    }
    epochs_ += 1;
  }

  MethodEstimate of(Method method) const {
    if (epochs_ == 0) throw DataError("", "the filter has no epoch in the run");
    MethodEstimate out{method, {}};
    for (int axis = 0; axis < kSignals; ++axis) {
      BiasScale line = lines_[static_cast<std::size_t>(axis)];
      line.value /= epochs_;
      line.covariance /= epochs_;
      line.hac_covariance = line.covariance;
      line.dof = kKnown;
      AxisEstimate& estimate = out.axes[static_cast<std::size_t>(axis)];
      const bool force = axis < 3;
      if (!layout_.has(force ? Block::kAccelBias : Block::kGyroBias)) continue;
      if (layout_.has(force ? Block::kAccelScale : Block::kGyroScale)) {
        estimate.line = line;
      } else {
        estimate.bias_alone = line.bias();
      }
    }
    return out;
  }

 private:
  // From the state to bias + drift and scale of one axis.
  Eigen::Matrix<double, 2, Eigen::Dynamic> selection(int axis) const {
    Eigen::Matrix<double, 2, Eigen::Dynamic> T = Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, layout_.size());
    const bool force = axis < 3;
    const auto take = [&](int row, Block block) {
      if (layout_.has(block)) T(row, layout_.offset(block) + axis % 3) = 1;
    };
    take(0, force ? Block::kAccelBias : Block::kGyroBias);
    take(0, force ? Block::kAccelDrift : Block::kGyroDrift);
    take(1, force ? Block::kAccelScale : Block::kGyroScale);
    return T;
  }

  StateLayout layout_;
  std::array<BiasScale, kSignals> lines_;
  double epochs_ = 0;
};

// Every tenth row of the run: biases change slowly.
std::vector<std::size_t> rows_of(const Solution& solution, const Interval& run) {
  constexpr std::size_t kEvery = 10;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < solution.size(); i += kEvery) {
    if (run.contains(solution.time(i))) rows.push_back(i);
  }
  return rows;
}

}  // namespace

std::vector<MethodEstimate> filter_estimates(const FilterCase& of, std::vector<std::string>& warnings) {
  std::vector<MethodEstimate> out;
  for (const Model& model : kModels) {
    if (model.attitude && of.options.attitude.empty()) continue;
    // With several IMUs a filter costs several times as much, so only the model of their sensor files is used.
    if (!of.options.imus.empty() && model.drift != of.options.sensor.gyro.drift.kind) continue;
    using Source = InitialHeading::Source;
    Log log = of.log;
    if (!model.attitude) log.attitude.clear();
    try {
      const Replay run =
          replay(std::move(log), {.filter = options_of(of, model),
                                  .heading = {.source = model.attitude ? Source::kAttitude : Source::kAuto},
                                  .smoother = SmootherKind::kNone});
      const Solution& solution = run.filtered.solution;
      Mean filtered(solution.layout()), smoothed(solution.layout());
      const std::vector<std::size_t> rows = rows_of(solution, of.run);
      smooth_rows(run.filtered, rows, [&](std::size_t, const FilterState& before, const SmoothedState&) {
        filtered.add(before.x, before.P);
      });
      smooth_rows(relinearised(run.log, run.options, without_alignment(run.log.world, run.found), run.filtered), rows,
                  [&](std::size_t, const FilterState&, const SmoothedState& after) { smoothed.add(after.x, after.P); });
      out.push_back(filtered.of(model.filtered));
      out.push_back(smoothed.of(model.smoothed));
    } catch (const DataError& e) {
      warnings.push_back(fmt::format("{} and its smoother: {}", info(model.filtered).title, e.what()));
    }
  }
  return out;
}

}  // namespace piste
