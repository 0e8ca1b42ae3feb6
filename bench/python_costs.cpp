// python_costs CONFIG: the CPU time of a replay with its verdict and without its outputs, and of a sample in
// Filter::add. For bench/python_costs.py, which measures the same through Python.

#include <fmt/format.h>

#include <ctime>
#include <exception>

#include "piste/batch.h"
#include "piste/diagnosis/diagnose.h"
#include "piste/piste.h"

namespace {

using namespace piste;

double seconds_since(std::clock_t start) { return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC; }

void measure(const char* file) {
  const std::clock_t at_replay = std::clock();
  const ReplayConfig config = read_replay_config(file);
  const Replay run = replay(config, {}, batch_solver(config.batch));
  const Solution* smoothed = run.smoothed ? &*run.smoothed : nullptr;
  diagnose(run.log, run.options, config.initial, run.found, run.filtered.solution, smoothed, [](double) {});
  const double replayed = seconds_since(at_replay);

  Filter filter(run.options, run.log.world, run.found.start);
  std::size_t samples = 0;
  const std::clock_t at_add = std::clock();
  for (const ImuSample& sample : run.log.imu) {
    if (sample.time <= run.found.start.time) continue;
    filter.add(sample);
    filter.clear_innovations();
    ++samples;
  }
  fmt::print("{:.4f} {:.4f}\n", replayed, 1e6 * seconds_since(at_add) / static_cast<double>(samples));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    fmt::print(stderr, "usage: python_costs CONFIG\n");
    return 2;
  }
  measure(argv[1]);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}
