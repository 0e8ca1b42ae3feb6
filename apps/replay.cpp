/// replay CONFIG: computes the trajectory and the errors of the IMU, with their sigmas, from raw logs.

#include "piste/replay/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>

#include "app.h"
#include "piste/batch/batch.h"
#include "piste/consistency/warnings.h"
#include "piste/diagnosis/diagnose.h"
#include "piste/files/replay.h"
#include "piste/outputs/replay_folder.h"

namespace piste {
namespace {

constexpr std::size_t kPerCent = 100;

void run_replay(const AppArguments& arguments, Progress& progress) {
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  const ReplayConfig config = read_replay_config(arguments.input);
  OutputFolder output(arguments.output);

  const auto extras = [&](double time) { return row_extras(config, gps_week(config, time)); };
  extras(0);  // throws before the work if the week is missing
  RowFiles rows(output, config.rates, config.smoother, true, extras);
  const Replay run = replay(
      config,
      [&](std::string_view stage, std::size_t done, std::size_t all) {
        if (done == 0) progress.start(std::string(stage), all);
        progress.update(done);
      },
      batch_solver(config.batch, std::max(1U, std::thread::hardware_concurrency())),
      config.needs_history() ? RowStreams{} : rows.streams());
  progress.clear();

  const Solution& filtered = run.filtered.solution;
  const Solution* smoothed = run.smoothed ? &*run.smoothed : nullptr;
  const auto per_cent = [&](double part) {
    progress.update(static_cast<std::size_t>(part * static_cast<double>(kPerCent)));
  };
  progress.start("verdict", kPerCent, "%");
  const Verdict verdict =
      diagnose(run.log, run.options, config.initial, run.found, filtered, smoothed, per_cent, run.residuals);
  progress.clear();
  progress.start("writing", kPerCent, "%");
  const auto times = [&] {
    const std::chrono::duration<double> wall_s = std::chrono::steady_clock::now() - wall;
    return RunTimes{static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC, wall_s.count()};
  };
  write_replay(output, config, run, verdict, times, per_cent, &rows);
  output.commit();
  progress.clear();

  for (const std::string& line : replay_warnings(config, run, verdict)) {
    fmt::print(stderr, "warning: {}\n", line);
  }
  for (const std::string& line : absence_lines(run.log.counts.imus)) say(arguments, line);
  say(arguments, run.found.how);
  if (smoothed && smoothed->batch) say(arguments, batch_line(*smoothed->batch));
  if (!filtered.adapted.names.empty()) say(arguments, adapted_line(filtered.adapted));
  if (smoothed) say(arguments, attitude_entry(output.folder() / "attitude.csv", *smoothed));
  say(arguments, "written to " + output.folder().string());
  say(arguments, verdict_line(verdict));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  return piste::run_app({.name = "replay",
                         .summary = "Computes a trajectory and IMU errors from raw logs. Takes an IMU and GNSS "
                                    "receivers; every result has its sigma."},
                        argc, argv, piste::run_replay);
}
