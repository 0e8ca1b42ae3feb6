// What a batch costs by the length of its run: to solve, and to give all sigmas.

#include "piste/batch/batch.h"

#include <benchmark/benchmark.h>

#include "support/synthetic_log.h"

namespace piste {
namespace {

// IMU at 100 Hz, fixes at 10 Hz of one receiver.
struct Filtered {
  explicit Filtered(double duration)
      : run(test::synthetic_run(duration, {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift,
                                           Block::kGyroScale, Block::kAccelScale})) {
    run.log.gnss.resize(1);
    run.log.attitude.clear();
    run.log.magnetic.clear();
    run.options.gnss.resize(1);
    run.options.attitude.clear();
    filtered = run_filter(run.log, run.options, run.start);
  }
  std::unique_ptr<BatchRun> solved(std::size_t threads = 1) const {
    return run_batch(run.log, run.options, {run.start, "given"}, filtered, {}, {}, threads);
  }

  test::SyntheticRun run;
  FilterRun filtered;
};

void tell(benchmark::State& state, const BatchRun& batch) {
  state.counters["nodes"] = static_cast<double>(batch.summary().nodes);
  state.counters["rounds"] = batch.summary().rounds;
}

void solve(benchmark::State& state) {
  const Filtered f(static_cast<double>(state.range(0)));
  std::unique_ptr<BatchRun> batch;
  for (auto _ : state) batch = f.solved(static_cast<std::size_t>(state.range(1)));
  tell(state, *batch);
}

// Of every node: epochs between nodes cost a product each.
void sigmas(benchmark::State& state) {
  const Filtered f(static_cast<double>(state.range(0)));
  const auto batch = f.solved();
  for (auto _ : state) benchmark::DoNotOptimize(batch->states({0}));
  tell(state, *batch);
}

// By seconds and threads; time on the clock, and CPU time of all threads.
BENCHMARK(solve)
    ->ArgsProduct({{270, 900, 3600}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(sigmas)->Arg(270)->Arg(900)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace piste
