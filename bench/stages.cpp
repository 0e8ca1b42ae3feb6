// stages CONFIG DIR: what each stage of a replay costs, in CPU time an epoch; what `replay CONFIG` does, step by step.

#include <fmt/format.h>

#include <ctime>
#include <exception>
#include <string_view>
#include <vector>

#include "piste/condition/pipeline.h"
#include "piste/diagnosis/diagnose.h"
#include "piste/files/replay.h"
#include "piste/report/html.h"
#include "piste/report/kml.h"
#include "piste/solve/attitude_noise.h"
#include "piste/solve/look_back.h"
#include "piste/solve/relinearise.h"
#include "piste/solve/rts.h"
#include "piste/solve/start.h"

namespace {

using namespace piste;

class Stopwatch {
 public:
  void lap(std::string_view stage) {
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
  std::vector<std::pair<std::string_view, double>> laps_;
};

void run(const char* file, const char* folder) {
  Stopwatch watch;
  const ReplayConfig config = read_replay_config(file);
  const Recording recording = read_recording(config);
  watch.lap("reading");
  Replay run;
  run.log = condition(recording, config.conditioning);
  run.options = with_white_part(with_attitude_sigmas(config.filter, recording.attitude), run.log);
  watch.lap("conditioning");
  run.found = find_start(run.log, run.options, config.initial);
  watch.lap("start");
  const bool smooth = config.smoother == SmootherKind::kRts;
  run.filtered = run_filter(run.log, run.options, run.found.start, smooth ? kCheckpointEvery : 0);
  watch.lap("filter");
  look_back(run.log, run.options, run.found, run.filtered.solution);
  watch.lap("looking back before the start");
  if (smooth) {
    run.relinearised = relinearised(run.log, run.options, run.found, run.filtered);
    watch.lap("smoother: first pass, filtered again");
    std::vector<AttitudeLag> lags;
    run.smoothed = smooth_rts(run.log, run.smoothable(), {}, nullptr, &lags);
    run.smoothed->attitude_correlation_time = correlation_time(lags);
    watch.lap("smoother: second pass");
  }
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
