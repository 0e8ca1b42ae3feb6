// stages CONFIG DIR: what each stage of a replay costs, in CPU time an epoch; what `replay CONFIG` does, step by step.

#include <fmt/format.h>

#include <algorithm>
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
    count(stage, std::clock() - last_);
    last_ = std::clock();
  }
  /// What lies between these counts for another stage.
  void pause() { paused_ = std::clock(); }
  void go_on(const std::string& stage) {
    const std::clock_t taken = std::clock() - paused_;
    count(stage, taken);
    last_ += taken;
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
  void count(const std::string& stage, std::clock_t taken) {
    auto lap = std::find_if(laps_.begin(), laps_.end(), [&](const auto& l) { return l.first == stage; });
    if (lap == laps_.end()) lap = laps_.insert(lap, {stage, 0});
    lap->second += static_cast<double>(taken) / CLOCKS_PER_SEC;
  }
  std::clock_t last_ = std::clock(), paused_ = 0;
  std::vector<std::pair<std::string, double>> laps_;
};

void run(const char* file, const char* folder) {
  Stopwatch watch;
  const ReplayConfig config = read_replay_config(file);
  const Recording recording = read_recording(config);
  std::string stage = "conditioning, start";
  watch.lap("reading");
  OutputFolder output(folder);
  RowFiles rows(output, config.rates, config.smoother, false);
  ReplayOptions options = replay_options(config);
  const auto timed = [&watch](const RowTaker& taker) {
    return [&watch, taker](Solution& next, std::size_t first) {
      watch.pause();
      taker(next, first);
      watch.go_on("rows to files");
    };
  };
  options.streams = rows.streams();
  options.streams.filtered = timed(options.streams.filtered);
  options.streams.smoothed = timed(options.streams.smoothed);
  const Replay run = replay(recording, options, [&](std::string_view next, std::size_t done, std::size_t) {
    if (done > 0) return;
    watch.lap(stage);
    stage = next;
  });
  watch.lap(stage);
  const Solution* smoothed = run.smoothed ? &*run.smoothed : nullptr;
  const Verdict verdict = diagnose(
      run.log, run.options, config.initial, run.found, run.filtered.solution, smoothed, [](double) {}, run.residuals);
  watch.lap("verdict");
  write_solutions(output, run, config.rates, {}, &rows);
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
  output.write("summary.json", summary_json(run.log, run.filtered.solution, smoothed, verdict, {},
                                            rows.begun() ? &rows.means() : nullptr));
  watch.lap("page, KML, summary");
  output.commit();
  watch.print(run.filtered.epochs);
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
