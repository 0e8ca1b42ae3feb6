// What the innermost calls cost. Run: build/release/bench/piste_bench

#include <benchmark/benchmark.h>

#include "piste/core/estimate.h"
#include "piste/math/earth.h"

namespace {

using namespace piste;

FullError some_error() { return FullError::LinSpaced(-0.03, 0.05); }

void box_plus(benchmark::State& state) {
  Estimate x;
  const FullError error = some_error();
  for (auto _ : state) benchmark::DoNotOptimize(x = boxplus(x, error));
}
BENCHMARK(box_plus);

void box_minus(benchmark::State& state) {
  const Estimate x, y = boxplus(x, some_error());
  for (auto _ : state) benchmark::DoNotOptimize(boxminus(y, x));
}
BENCHMARK(box_minus);

void world_gravity(benchmark::State& state) {
  const World world({0.8, 0.1, 1500});
  Vector3d p(100, 200, -50);
  for (auto _ : state) {
    benchmark::DoNotOptimize(world.gravity(p));
    p.x() += 1e-3;
  }
}
BENCHMARK(world_gravity);

}  // namespace
