/// montecarlo SCENARIO: are the filter's sigmas consistent with its errors, and how near are the errors to the bound?

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "app.h"
#include "piste/batch/batch.h"
#include "piste/core/error.h"
#include "piste/outputs/folders.h"
#include "piste/report/consistency_text.h"
#include "piste/trial/ensemble.h"

namespace piste {
namespace {

constexpr const char* kState = "ensemble.state";

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ConfigError(file.string(), "cannot be read; give a file that `--sums` wrote");
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The trials from `first` on. Trials of this scenario that an earlier run left in the file come first. A file with more
// trials than wanted is an error, not overwritten: they may have taken hours.
Ensemble begin(const AppArguments& arguments, const Scenario& scenario, const std::filesystem::path& file,
               std::size_t first, std::size_t runs) {
  if (!std::filesystem::exists(file)) return Ensemble(scenario, batch_solver(), first);
  Ensemble ensemble(scenario, batch_solver(), first);
  if (ensemble.resume(bytes_of(file))) {
    if (ensemble.size() > runs) {
      throw ConfigError("--runs", fmt::format("{} holds {} runs of this scenario already; ask for as many or more, or "
                                              "for another folder",
                                              file.string(), ensemble.size()));
    }
    say(arguments, fmt::format("going on after {} runs", ensemble.size()));
    return ensemble;
  }
  say(arguments, fmt::format("the runs in {} are of something else; starting anew", file.string()));
  return Ensemble(scenario, batch_solver(), first);
}

// Makes the trials, and saves them in the file now and then.
Ensemble simulated(const AppArguments& arguments, const Scenario& scenario, OutputFolder& output,
                   const std::string& state, std::size_t first, Progress& progress) {
  constexpr std::chrono::seconds kSaveEvery{5};
  const auto runs = static_cast<std::size_t>(arguments.integers.at("runs"));
  Ensemble ensemble = begin(arguments, scenario, output.folder() / state, first, runs);
  progress.start("montecarlo", runs, "runs", ensemble.size());
  std::chrono::steady_clock::time_point saved{};  // in the past, so that the first run is saved at once
  ensemble.run(runs, static_cast<std::size_t>(arguments.integers.at("jobs")), [&](const Ensemble& so_far) {
    progress.update(so_far.size());
    const auto now = std::chrono::steady_clock::now();
    if (now - saved < kSaveEvery && so_far.size() < runs) return;
    saved = now;
    output.write(state, so_far.save());
    output.commit();
  });
  progress.clear();
  return ensemble;
}

// Merges the parts that follow the scenario on the command line.
Ensemble merged(const AppArguments& arguments, const Scenario& scenario) {
  Ensemble ensemble(scenario, batch_solver());
  for (std::size_t i = 1; i < arguments.inputs.size(); ++i) {
    try {
      ensemble.append(bytes_of(arguments.inputs[i]));
    } catch (const DataError& e) {
      throw DataError(arguments.inputs[i], e.what());
    }
  }
  return ensemble;
}

void run(const AppArguments& arguments, Progress& progress) {
  const Scenario scenario = read_scenario(arguments.input);
  if (scenario.gnss.empty()) throw ConfigError(arguments.input, "names no receiver under `gnss:`; a replay needs one");
  const bool merges = arguments.inputs.size() > 1;
  const auto first = static_cast<std::size_t>(arguments.integers.at("first"));
  if (const auto sums = arguments.files.find("sums"); sums != arguments.files.end()) {
    if (merges) throw ConfigError("--sums", "makes a part, and merges none; leave it out, or the parts");
    const std::filesystem::path file = std::filesystem::absolute(sums->second);
    OutputFolder output(file.parent_path());
    const Ensemble part = simulated(arguments, scenario, output, file.filename().string(), first, progress);
    say(arguments, fmt::format("runs {} to {} in {}", first, first + part.size() - 1, file.string()));
    return;
  }
  if (first > 0) throw ConfigError("--first", "makes a part of an ensemble; say with --sums FILE where it belongs");
  OutputFolder output(arguments.output);
  const Ensemble ensemble =
      merges ? merged(arguments, scenario) : simulated(arguments, scenario, output, kState, first, progress);

  const ConsistencyReport report = ensemble.sums().report();
  if (report.runs == 0) throw DataError(arguments.input, "no run could be replayed; " + report.failures.front().what);
  const std::string title = std::filesystem::path(arguments.input).stem().string();
  output.write(kState, ensemble.save());
  write_consistency(output, report, title, scenario.text);
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
          "Tests over many simulated runs whether the sigmas hold. Simulates and replays a scenario; writes NEES and "
          "NIS with their bands, and errors over the bound. Goes on where it was stopped; the numbers do not depend "
          "on the jobs.",
      .input = "SCENARIO",
      .input_help =
          "scenario file (YAML), such as config/scenarios/montecarlo/ski_l1l2.yaml; behind it the parts that --sums "
          "wrote, in their order, if they are to be merged",
      .many_inputs = true,
      .integers = {{"runs", "in all; those that stand in the folder already count", 100, 1},
                   {"first", "number of the first run, with --sums", 0},
                   {"jobs", "runs at a time", cores, 1, "one for each core"}},
      .files = {{"sums", "makes only a part of the runs, and writes what merges with other parts"}},
  };
  return piste::run_app(description, argc, argv, piste::run);
}
