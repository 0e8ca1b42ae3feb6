/// Raw logs in; trajectory, IMU errors and their sigmas out.

#include <fmt/format.h>

#include <chrono>
#include <ctime>

#include "app.h"
#include "piste/condition/pipeline.h"
#include "piste/condition/rest_detection.h"
#include "piste/consistency/disputes.h"
#include "piste/core/version.h"
#include "piste/files/summary.h"
#include "piste/io/output.h"
#include "piste/io/replay_config.h"
#include "piste/io/solution_io.h"
#include "piste/report/html.h"
#include "piste/report/kml.h"
#include "piste/solve/attitude_noise.h"
#include "piste/solve/rts.h"
#include "piste/solve/start.h"

namespace {

// What the gate refused of a source, where it is too much for outliers: then something else is wrong.
void warn_of_rejections(const piste::Solution& solution) {
  constexpr double kTooMany = 0.2;
  constexpr int kFew = 20;
  std::vector<int> all(solution.sources.size()), rejected(solution.sources.size());
  for (const piste::Innovation& v : solution.innovations) {
    const auto source = static_cast<std::size_t>(v.source);
    ++all[source];
    rejected[source] += piste::was_used(v.outcome) ? 0 : 1;
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i] < kFew || rejected[i] <= kTooMany * all[i]) continue;
    fmt::print(stderr,
               "warning: {} of {} measurements of {} were rejected, and the solution is not to be relied on; check its "
               "units, sigmas and lever arm, and the clock and the axes of the IMU\n",
               rejected[i], all[i], solution.sources[i]);
  }
  for (const piste::Dispute& dispute : piste::disputes_of(solution)) {
    if (solution.sources[static_cast<std::size_t>(dispute.source)].starts_with("gnss"))
      fmt::print(stderr, "warning: {}\n", piste::text_of(dispute, solution));
  }
}

// attitude.csv as the configuration of another replay names it.
std::string attitude_entry(const piste::OutputFolder& output, const piste::Solution& smoothed) {
  const double tau = smoothed.attitude_correlation_time, all = smoothed.time(smoothed.size() - 1) - smoothed.time(0);
  return fmt::format("as a reference for another replay: `attitude: {{file: {}, correlation_time: {:.1f} s}}`{}",
                     std::filesystem::absolute(output.folder() / "attitude.csv").lexically_normal().string(), tau,
                     tau < 0.999 * all ? "" : ", the length of the log: the error does not fade within it");
}

void replay(const piste::AppArguments& arguments, piste::Progress& progress) {
  using namespace piste;
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  const ReplayConfig config = read_replay_config(arguments.input);
  OutputFolder output(arguments.output);

  const Recording recording = read_recording(config);
  FilterOptions options = filter_options(config, recording);
  Log log = condition(recording, config.conditioning);
  mark_rest(log, config.conditioning.rest);
  measure_white_part(log, options);

  const auto show = [&](double fraction) {
    progress.update(static_cast<std::size_t>(fraction * static_cast<double>(log.imu.size())));
  };
  const FoundStart found = find_start(log, options, config.initial);
  const bool smooth = config.smoother == SmootherKind::kRts;
  progress.start("filter", log.imu.size());
  const FilterRun run = run_filter(log, options, found.start, smooth ? kCheckpointEvery : 0, show);
  std::optional<Solution> smoothed;
  if (smooth) {
    progress.start("smoother", log.imu.size());
    std::vector<AttitudeLag> lags;
    smoothed = smooth_rts(log, run, show, nullptr, &lags);
    smoothed->attitude_correlation_time = correlation_time(lags);
  }
  progress.clear();

  const Solution* final_solution = smoothed ? &*smoothed : nullptr;
  output.write("filtered.csv", navigation_csv(run.solution));
  output.write("biases.csv", biases_csv(run.solution));
  output.write("innovations.csv", innovations_csv(run.solution));
  if (smoothed) {
    output.write("smoothed.csv", navigation_csv(*smoothed));
    output.write("biases_smoothed.csv", biases_csv(*smoothed));
  } else {
    output.withdraw("smoothed.csv");
    output.withdraw("biases_smoothed.csv");
  }
  output.write("attitude.csv", attitude_csv(final_solution ? *final_solution : run.solution, config.attitude_rate));
  const std::string title = config.file.stem().string();
  output.write("trajectory.kml", kml(final_solution ? *final_solution : run.solution, title));
  output.write("report.html", html_report({.title = title,
                                           .version = version(),
                                           .config_text = config.echo,
                                           .log = &log,
                                           .filtered = &run.solution,
                                           .smoothed = final_solution,
                                           .outages = config.conditioning.outages}));
  const std::chrono::duration<double> wall_s = std::chrono::steady_clock::now() - wall;
  const RunTimes times{static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC, wall_s.count()};
  output.write("summary.json", summary_json(log, run.solution, final_solution, times));
  output.commit();
  warn_of_rejections(run.solution);
  say(arguments, found.how);
  if (smoothed) say(arguments, attitude_entry(output, *smoothed));
  say(arguments, "written to " + output.folder().string());
}

}  // namespace

int main(int argc, char** argv) {
  return piste::run_app(
      {.name = "replay",
       .summary = "Raw logs of an IMU and GNSS in; trajectory, the IMU's errors and their sigmas out."},
      argc, argv, replay);
}
