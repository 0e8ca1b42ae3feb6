/// montecarlo SCENARIO: are the filter's sigmas true, and how near are its errors to the bound?

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "app.h"
#include "piste/core/error.h"
#include "piste/core/version.h"
#include "piste/experiment/ensemble.h"
#include "piste/files/consistency.h"
#include "piste/files/output.h"
#include "piste/report/consistency_page.h"
#include "piste/report/consistency_text.h"
#include "piste/solve/batch.h"

namespace piste {
namespace {

constexpr const char* kState = "ensemble.state";

// The ensemble that an earlier run left in the folder, if it is of this scenario and not larger than wanted; else an
// empty one.
Ensemble begin(const AppArguments& arguments, const Scenario& scenario, std::size_t runs) {
  std::ifstream file(arguments.output / kState, std::ios::binary);
  if (!file) return Ensemble(scenario, batch_solver());
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  Ensemble ensemble(scenario, batch_solver());
  if (ensemble.resume(bytes) && ensemble.size() <= runs) {
    say(arguments, fmt::format("going on after {} runs", ensemble.size()));
    return ensemble;
  }
  say(arguments,
      fmt::format("the runs in {} are more, or of something else; starting anew", arguments.output.string()));
  return Ensemble(scenario, batch_solver());
}

void run(const AppArguments& arguments, Progress& progress) {
  constexpr std::chrono::seconds kSaveEvery{5};
  const Scenario scenario = read_scenario(arguments.input);
  if (scenario.gnss.empty()) throw ConfigError(arguments.input, "names no receiver under `gnss:`; a replay needs one");
  const auto runs = static_cast<std::size_t>(arguments.integers.at("runs"));
  OutputFolder output(arguments.output);

  Ensemble ensemble = begin(arguments, scenario, runs);
  progress.start("montecarlo", runs, "runs", ensemble.size());
  std::chrono::steady_clock::time_point saved{};  // in the past, so that the first run is saved at once
  ensemble.run(runs, static_cast<std::size_t>(arguments.integers.at("jobs")), [&](const Ensemble& so_far) {
    progress.update(so_far.size());
    const auto now = std::chrono::steady_clock::now();
    if (now - saved < kSaveEvery && so_far.size() < runs) return;
    saved = now;
    output.write(kState, so_far.save());
    output.commit();
  });
  progress.clear();

  const ConsistencyReport report = ensemble.sums().report();
  if (report.runs == 0) throw DataError(arguments.input, "no run could be replayed; " + report.failures.front().what);
  const std::string title = std::filesystem::path(arguments.input).stem().string();
  output.write("consistency.json", consistency_json(report, title));
  output.write("consistency.md", consistency_row_head() + consistency_row(report, title));
  output.write("consistency.html", consistency_html(report, title, version(), scenario.text));
  output.commit();
  say(arguments, consistency_text(report));
  say(arguments, "written to " + arguments.output.string());
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  const auto cores = static_cast<long>(std::max(1U, std::thread::hardware_concurrency()));
  const piste::AppDescription description{
      .name = "montecarlo",
      .summary =
          "Simulates and replays a scenario many times: NEES and NIS with their bands, errors over the bound. Goes "
          "on where it was stopped; the numbers do not depend on the jobs.",
      .input = "SCENARIO",
      .input_help = "scenario file (YAML), such as config/scenarios/montecarlo/ski_l1l2.yaml",
      .integers = {{"runs", "in all; those that stand in the folder already count", 100, 1},
                   {"jobs", "runs at a time", cores, 1, "one for each core"}},
  };
  return piste::run_app(description, argc, argv, piste::run);
}
