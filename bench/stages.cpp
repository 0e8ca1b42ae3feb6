// stages CONFIG DIR: what each stage of a replay costs, in CPU time an epoch; what `replay CONFIG` does, step by step.

#include <fmt/format.h>

#include <ctime>
#include <exception>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "piste/diagnosis/diagnose.h"
#include "piste/files/replay.h"
#include "piste/report/html.h"
#include "piste/report/kml.h"

namespace {

using namespace piste;

class Stopwatch {
 public:
  void lap(const std::string& stage) {
    const std::clock_t now = std::clock();
    laps_.emplace_back(stage, static_cast<double>(now - last_) / CLOCKS_PER_SEC);
    last_ = std::clock();
  }
  void print(std::size_t epochs) const {
    double total = 0;
    for (const auto& [stage, seconds] : laps_) {
      fmt::print("| {:<40} | {:>6.0f} |\n", stage, 1e9 * seconds / static_cast<double>(epochs));
      total += seconds;
    }
    fmt::print("| {:<40} | {:>6.0f} |\n{} epochs, {:.2f} s\n", "all", 1e9 * total / static_cast<double>(epochs), epochs,
               total);
  }

 private:
  std::clock_t last_ = std::clock();
  std::vector<std::pair<std::string, double>> laps_;
};

void run(const char* file, const char* folder) {
  Stopwatch watch;
  const ReplayConfig config = read_replay_config(file);
  const Recording recording = read_recording(config);
  std::string stage = "conditioning, start";
  watch.lap("reading");
  const Replay run =
      replay(recording, replay_options(config), [&](std::string_view next, std::size_t done, std::size_t) {
        if (done > 0) return;
        watch.lap(stage);
        stage = next;
      });
  watch.lap(stage);
  const Solution* smoothed = run.smoothed ? &*run.smoothed : nullptr;
  const Verdict verdict =
      diagnose(run.log, run.options, config.initial, run.found, run.filtered.solution, smoothed, [](double) {});
  watch.lap("verdict");
  OutputFolder output(folder);
  write_solutions(output, run, config.rates);
  watch.lap("rows to files");
  output.write("trajectory.kml", kml(run.solution(), "stages"));
  output.write("report.html", html_report({.title = "stages",
                                           .version = "",
                                           .config_text = config.echo,
                                           .log = &run.log,
                                           .filtered = &run.filtered.solution,
                                           .smoothed = smoothed,
                                           .verdict = &verdict,
                                           .outages = config.conditioning.outages}));
  watch.lap("page and KML");
  output.commit();
  watch.print(run.filtered.solution.size());
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    fmt::print(stderr, "usage: stages CONFIG DIR\n");
    return 2;
  }
  run(argv[1], argv[2]);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}
