// What writing a run costs.

#include <benchmark/benchmark.h>

#include <vector>

#include "piste/io/solution_io.h"

namespace {

using namespace piste;

void write_navigation(benchmark::State& state) {
  const auto epochs = static_cast<std::size_t>(state.range(0));
  Solution solution(StateLayout(std::vector<Block>{}), World({0.8, 0.1, 1500}));
  solution.reserve(epochs);
  Sigmas sigmas;
  sigmas.position = sigmas.velocity = sigmas.euler = Vector3d::Constant(0.1);
  for (std::size_t i = 0; i < epochs; ++i) {
    Estimate x;
    x.p_wb = {0.13 * static_cast<double>(i), 1.7, -0.2};
    x.v_wb = {13, 0.25, -0.5};
    solution.append(0.01 * static_cast<double>(i), x, sigmas);
  }
  for (auto _ : state) benchmark::DoNotOptimize(navigation_csv(solution));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(write_navigation)->Arg(55000)->Unit(benchmark::kMillisecond);

}  // namespace
