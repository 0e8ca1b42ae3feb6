#include "piste/outputs/replay_folder.h"

#include <fmt/format.h>

#include <array>
#include <functional>
#include <utility>

#include "math/parallel.h"
#include "outputs/own_replay.h"
#include "piste/core/version.h"
#include "piste/diagnosis/run_warnings.h"
#include "piste/files/replay.h"
#include "piste/report/html.h"
#include "piste/report/kml.h"

namespace piste {
namespace {

const Solution* smoothed_of(const Replay& run) { return run.smoothed ? &*run.smoothed : nullptr; }

std::string title_of(const ReplayConfig& config) { return config.file.stem().string(); }

std::optional<int> week_of(const ReplayConfig& config, const Replay& run) {
  return run.log.imu.empty() ? config.output.week : gps_week(config, run.log.imu.front().time);
}

}  // namespace

std::vector<std::string> replay_warnings(const ReplayConfig& config, const Replay& run, const Verdict& verdict) {
  std::vector<std::string> all;
  if (config.echo.starts_with(kOwnReplaySays)) {
    const std::string_view rest = std::string_view(config.echo).substr(kOwnReplaySays.size());
    all.push_back(fmt::format("inspect wrote in this configuration: {}", rest.substr(0, rest.find('\n'))));
  }
  for (std::string& line : run_warnings(run.log, run.options, run.filtered.solution, config.conditioning.outages)) {
    all.push_back(std::move(line));
  }
  if (const Solution* smoothed = smoothed_of(run); smoothed && smoothed->batch && !smoothed->batch->converged) {
    all.emplace_back("the batch has not converged; compare with `smoother: rts`");
  }
  const std::string line = verdict_line(verdict);
  const bool said = !all.empty() && all.front().find(line) != std::string::npos;  // by inspect, of the same run
  if (!verdict.consistent && !said) all.push_back(line);
  return all;
}

std::string replay_page(const ReplayConfig& config, const Replay& run, const Verdict& verdict) {
  return html_report({.title = title_of(config),
                      .version = version(),
                      .config_text = config.echo,
                      .log = &run.log,
                      .filtered = &run.filtered.solution,
                      .smoothed = smoothed_of(run),
                      .verdict = &verdict,
                      .outages = config.conditioning.outages,
                      .options = &run.options,
                      .warnings = replay_warnings(config, run, verdict),
                      .rate = config.rates.navigation,
                      .week = week_of(config, run),
                      .bias_rate = config.rates.biases});
}

void write_replay(OutputFolder& output, const ReplayConfig& config, const Replay& run, const Verdict& verdict,
                  const std::function<RunTimes()>& times, const std::function<void(double)>& progress, RowFiles* rows) {
  std::string map, page;
  const std::optional<int> week = week_of(config, run);
  const RowExtras extras = row_extras(config, week, &run.log);
  const std::array<std::function<void()>, 3> parts{
      [&] { write_solutions(output, run, config.rates, progress, rows, extras); },
      [&] { page = replay_page(config, run, verdict); }, [&] { map = kml(run.solution(), title_of(config), week); }};
  for_each_parallel(parts.size(), parts.size(), [&](std::size_t i) { parts[i](); });
  write_asked(output, run, config, extras);
  output.write("trajectory.kml", map);
  output.write("report.html", page);
  output.write("summary.json", summary_json(run.log, run.filtered.solution, smoothed_of(run), verdict, times(),
                                            rows != nullptr && rows->begun() ? &rows->means() : nullptr, week,
                                            replay_warnings(config, run, verdict)));
}

}  // namespace piste
