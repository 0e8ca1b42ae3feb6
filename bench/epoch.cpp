// What an epoch of filter and smoother costs, in its parts and whole, at 27 states and more.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "model/dynamics.h"
#include "piste/filter/update.h"
#include "piste/model/gnss.h"
#include "piste/smoother/rts.h"
#include "support/synthetic_log.h"

namespace {

using namespace piste;

std::vector<Block> ski_blocks() {
  return {Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
          Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};
}

// Also of a lever arm, a receiver's slow error and the cross-axis errors of the IMU.
std::vector<Block> as_sold() {
  std::vector<Block> blocks = ski_blocks();
  blocks.insert(blocks.end(),
                {Block::kLeverArm, Block::kGnssPositionDrift, Block::kGyroCrossAxis, Block::kAccelCrossAxis});
  return blocks;
}

// One step and one fix in the middle of a run.
struct Scene {
  test::SyntheticRun run = test::synthetic_run(5, ski_blocks());
  StateLayout layout{ski_blocks()};
  Vector3d earth_rate = run.log.world.earth_rate();
  Estimate x = run.start.x;
  Gravity gravity = run.log.world.gravity(x.p_wb);
  ImuStep step = correct(make_step(&run.log.imu[300], run.log.imu[301], &run.log.imu[302]), x);
  Transition transition;
  Covariance P;
  Linearization fix;

  Scene() {
    Estimate end = x;
    mechanize(end, step, earth_rate, gravity);
    transition = linearize(x, end, step, earth_rate, gravity, {Vector3d::Ones() * 1e-6, Vector3d::Ones() * 1e-5});
    add_processes(transition, layout, run.options, step.dt);
    P = test::Random(1).covariance(layout.size());
    const BodyMotion motion{.rate = step.mean_rate(), .force = step.mean_force()};
    fix = linearize_position(run.log.gnss[1][5], {}, x, {motion}, earth_rate, gravity);
  }
};

void step_mechanize(benchmark::State& state) {
  const Scene s;
  Estimate x = s.x;
  for (auto _ : state) {
    mechanize(x, s.step, s.earth_rate, s.gravity);
    benchmark::DoNotOptimize(x);
  }
}
BENCHMARK(step_mechanize);

void step_linearize(benchmark::State& state) {
  const Scene s;
  const StepNoise noise{Vector3d::Ones() * 1e-6, Vector3d::Ones() * 1e-5};
  for (auto _ : state) benchmark::DoNotOptimize(linearize(s.x, s.x, s.step, s.earth_rate, s.gravity, noise));
}
BENCHMARK(step_linearize);

void step_propagate(benchmark::State& state) {
  const Scene s;
  Covariance P = s.P;
  for (auto _ : state) {
    propagate(P, s.layout, s.transition);
    benchmark::DoNotOptimize(P.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(step_propagate);

void step_propagate_dense(benchmark::State& state) {
  const Scene s;
  const Eigen::MatrixXd Phi = dense_transition(s.layout, s.transition);
  Eigen::MatrixXd P = s.P, half = P;
  for (auto _ : state) {
    half.noalias() = Phi * P;
    P.noalias() = half * Phi.transpose();
    benchmark::DoNotOptimize(P.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(step_propagate_dense);

void update_innovate(benchmark::State& state) {
  const Scene s;
  for (auto _ : state) benchmark::DoNotOptimize(innovate(s.P, s.layout, s.fix));
}
BENCHMARK(update_innovate);

void update_covariance(benchmark::State& state) {
  const Scene s;
  const Update u = innovate(s.P, s.layout, s.fix);
  Covariance P = s.P;
  for (auto _ : state) {
    update(P, u);
    benchmark::DoNotOptimize(P.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(update_covariance);

void update_reset(benchmark::State& state) {
  const Scene s;
  const ResetJacobian G = reset_jacobian(FullError::Constant(1e-4));
  Covariance P = s.P;
  for (auto _ : state) {
    reset(P, s.layout, G);
    benchmark::DoNotOptimize(P.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(update_reset);

void adjoint_update(benchmark::State& state) {
  const Scene s;
  const Update u = innovate(s.P, s.layout, s.fix);
  Covariance Lambda = s.P;
  ErrorVector lambda = Lambda.col(0);
  for (auto _ : state) {
    update_adjoint(lambda, Lambda, u);
    benchmark::DoNotOptimize(Lambda.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(adjoint_update);

// Whole epochs of a run with one receiver at 10 Hz; the time is that of one epoch.
void epochs(benchmark::State& state, bool smooth) {
  test::SyntheticRun s = test::synthetic_run(20, ski_blocks());
  s.log.gnss[1].clear();
  s.log.attitude[0].clear();
  s.log.magnetic.clear();
  for (auto _ : state) {
    const FilterRun run = run_filter(s.log, s.options, s.start, smooth ? Keep::kHistory : Keep::kNothing);
    if (smooth) benchmark::DoNotOptimize(smooth_rts(run));
  }
  const auto count = state.iterations() * static_cast<benchmark::IterationCount>(s.log.imu.size());
  state.counters["epoch"] =
      benchmark::Counter(static_cast<double>(count), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(epochs, filter, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(epochs, filter_and_smoother, true)->Unit(benchmark::kMillisecond);

// What a live program waits for: one sample, with the fixes up to its time. Of a million of them the median, and what
// one in ten thousand exceeds, in ns.
void live_add(benchmark::State& state, const std::vector<Block>& blocks) {
  constexpr double kDuration = 10'000;
  test::SyntheticRun s = test::synthetic_run(kDuration, blocks);
  s.options.gnss[0].drift = PositionDrift{{.sigma = Vector3d::Ones(), .correlation_time = 60}};
  const auto& fixes = s.log.gnss[0];
  std::vector<double> times;
  times.reserve(s.log.imu.size());
  for (auto _ : state) {
    Filter filter(s.options, s.log.world, s.start);
    std::size_t fix = 0;
    for (const ImuSample& sample : s.log.imu) {
      const auto begin = std::chrono::steady_clock::now();
      for (; fix < fixes.size() && fixes[fix].time <= sample.time; ++fix) filter.add(0, fixes[fix]);
      filter.add(sample);
      times.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count());
      filter.clear_innovations();
    }
    state.counters["states"] = static_cast<double>(filter.layout().size());
  }
  std::sort(times.begin(), times.end());
  state.counters["calls"] = static_cast<double>(times.size());
  state.counters["median_ns"] = times[times.size() / 2];
  state.counters["p99_ns"] = times[times.size() / 100 * 99];
  state.counters["p9999_ns"] = times[times.size() / 10'000 * 9'999];
}
BENCHMARK_CAPTURE(live_add, 27, ski_blocks())->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(live_add, 42, as_sold())->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
