// Allan variance of a million samples an axis: the sums alone, and with the robust variance.

#include <benchmark/benchmark.h>

#include <vector>

#include "piste/allan/allan_variance.h"
#include "piste/allan/gmwm.h"
#include "support/random.h"

namespace piste {
namespace {

const std::vector<double>& samples() {
  static const std::vector<double> all = [] {
    test::Random random(1);
    std::vector<double> x(1'000'000);
    for (double& v : x) v = random.gaussian();
    return x;
  }();
  return all;
}

void allan(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(allan_curve(samples(), 0.01, state.range(0) != 0));
}

void gmwm(benchmark::State& state) {
  const AllanCurve curve = allan_curve(samples(), 0.01);
  for (auto _ : state) benchmark::DoNotOptimize(fit_gmwm(curve));
}

BENCHMARK(allan)->ArgName("robust")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(gmwm)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace piste
