#include "piste/replay/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "filter/reference.h"
#include "io/row_rate.h"
#include "piste/condition/pipeline.h"
#include "piste/consistency/verdict.h"
#include "piste/core/error.h"
#include "piste/smoother/rts.h"
#include "piste/start/attitude_noise.h"
#include "piste/start/initial_stretch.h"
#include "smoother/relinearise.h"
#include "start/vehicle_mounting.h"

namespace piste {
namespace {

template <class Sources>
void check_sources(const Sources& sources, const FilterOptions& options) {
  const auto check = [](std::string_view kind, std::size_t there, std::size_t stated) {
    if (there == stated) return;
    throw ConfigError("filter options",
                      fmt::format("{}: options of {} sources for {}; one each is needed", kind, stated, there));
  };
  check("gnss", sources.gnss.size(), options.gnss.size());
  check("attitude", sources.attitude.size(), options.attitude.size());
}

// The log of a recording. Sets the sigmas of its attitudes in the options.
template <class AnyRecording>
Log conditioned(AnyRecording&& recording, ReplayOptions& options) {
  check_sources(recording, options.filter);
  options.filter = with_attitude_sigmas(std::move(options.filter), recording.attitude);
  return condition(std::forward<AnyRecording>(recording), options.conditioning);
}

// Keeps every n-th of the rows at a rate, and the last one.
class KeptRows {
 public:
  // `all`: number of rows; `length`: of the run [s].
  KeptRows(const StateLayout& layout, const World& world, std::size_t all, double length, double rate)
      : kept_(layout, world),
        last_(layout, world),
        at_(rate),
        every_(rows_apart(at_.all() ? all : std::min(all, static_cast<std::size_t>(length * rate) + 2))) {}
  void add(const Solution& rows) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (at_.all()) {
        take(rows.row(i));
      } else if (at_.next(rows.time(i))) {
        take(i > 0 ? rows.row(i - 1) : last_.row(0));
      }
    }
    if (rows.empty()) return;
    last_.resize(0);
    last_.append(rows.row(rows.size() - 1));
  }
  void give(Solution& to) {
    if (!last_.empty() && (kept_.empty() || kept_.time(kept_.size() - 1) < last_.time(0))) kept_.append(last_.row(0));
    to.append(kept_.rows());
  }

 private:
  void take(std::span<const double> row) {
    if (count_++ % every_ == 0) kept_.append(row);
  }
  Solution kept_, last_;
  RowRate at_;
  std::size_t every_, count_ = 0;
};

double length_of(const Log& log) { return log.imu.empty() ? 0 : log.imu.back().time - log.imu.front().time; }

// Filters the run from `run.found`. `streams`: take all rows, and the solution keeps a part of them; null: it keeps
// all.
FilterRun filtered(const Replay& run, const ReplayOptions& options, const RowStreams* streams, Keep keep,
                   const ProgressCallback& progress) {
  const double end = run.found.start.time + options.longest;
  if (streams == nullptr) return filter_from(run.stretch, run.log, run.options, run.found, keep, progress, end);
  KeptRows kept(StateLayout(run.options.estimate), run.log.world, run.log.imu.size(), length_of(run.log),
                streams->rate);
  FilterRun filtered = filter_from(
      run.stretch, run.log, run.options, run.found, keep, progress, end,
      [&](Solution& rows, std::size_t first) {
        kept.add(rows);
        streams->filtered(rows, first);
      },
      streams->scratch);
  kept.give(filtered.solution);
  return filtered;
}

// Smooths a run. All rows go to `options.streams`; the solution keeps a part of them.
Solution smoothed_in_pieces(Replay& run, const ReplayOptions& options, const ProgressCallback& progress,
                            std::vector<AttitudeLag>& lags) {
  const FilterRun& filtered = run.smoothable();
  KeptRows kept(filtered.solution.layout(), run.log.world, filtered.epochs, length_of(run.log), options.streams.rate);
  SmoothedResiduals residuals(run.log, run.options, run.filtered.solution);
  Solution smoothed = smooth_rts(filtered, progress, nullptr, &lags, [&](Solution& rows, std::size_t first) {
    kept.add(rows);
    residuals.add(rows);
    if (options.streams.smoothed) options.streams.smoothed(rows, first);
  });
  kept.give(smoothed);
  run.residuals = residuals.rms();
  return smoothed;
}

}  // namespace

ReplayOptions replay_options(const ReplayConfig& config) {
  return {.conditioning = config.conditioning,
          .filter = config.filter,
          .heading = config.initial,
          .smoother = config.smoother,
          .history = config.needs_history()};
}

Replay replay(const ReplayConfig& config, const ReplayProgress& progress, const BatchSolver& batch,
              const RowStreams& streams) {
  ReplayOptions options = replay_options(config);
  options.batch = batch;
  options.streams = streams;
  Log log = conditioned(read_recording(config), options);
  return replay(std::move(log), options, progress);
}

Replay replay(const Recording& recording, const ReplayOptions& options, const ReplayProgress& progress) {
  ReplayOptions known = options;
  Log log = conditioned(recording, known);
  return replay(std::move(log), known, progress);
}

Replay replay(Log log, const ReplayOptions& options, const ReplayProgress& progress) {
  check_sources(log, options.filter);
  const bool by_batch = options.smoother == SmootherKind::kBatch;
  if (by_batch && !options.batch) {
    throw ConfigError("smoother",
                      "batch needs piste::batch, with which this program was not linked; choose rts, or none");
  }
  const std::size_t all = log.imu.size();
  const auto stage = [&](std::string_view name) -> ProgressCallback {
    if (!progress) return {};
    progress(name, 0, all);
    return [&progress, name, all](double part) {
      progress(name, static_cast<std::size_t>(part * static_cast<double>(all)), all);
    };
  };
  Replay run{.log = std::move(log), .options = {}, .found = {}, .filtered = {}, .smoothed = {}};
  run.options = with_white_part(options.filter, run.log);
  if (!run.options.clock_from) run.options.clock_from = run.log.imu.front().time;
  run.found = options.start ? FoundStart{*options.start, "the start was given"}
                            : find_start(run.log, run.options, options.heading);
  run.options = with_mounting(std::move(run.options), run.log, run.found.start);
  const bool smooth = options.smoother == SmootherKind::kRts;
  const bool streams = options.streams.filtered && !by_batch, history = options.history && !streams;
  const Keep keep = smooth || history ? Keep::kHistory : Keep::kNothing;
  run.stretch = initial_stretch(run.log, run.options, run.found);
  run.filtered = filtered(run, options, streams ? &options.streams : nullptr, keep, stage("filter"));
  if (!history) run.stretch.run.history.reset();
  if (smooth) {
    std::vector<AttitudeLag> lags;
    for (int pass = 0; pass < options.relinearisations; ++pass) {
      const ProgressCallback report = stage("relinearising");
      Reference smoothed = smoothed_trajectory(run.smoothable(), part_of(report, 0, kSmoothingFirst));
      if (!history) run.filtered.history.reset();
      run.relinearised.reset();  // saves memory while the run is filtered again
      run.relinearised =
          filtered_about(std::move(smoothed), run.log, run.options, without_alignment(run.log.world, run.found),
                         part_of(report, kSmoothingFirst, 1));
    }
    run.smoothed = streams ? smoothed_in_pieces(run, options, stage("smoother"), lags)
                           : smooth_rts(run.smoothable(), stage("smoother"), nullptr, &lags);
    if (!history) run.relinearised.reset();
    if (!history) run.filtered.history.reset();
    run.smoothed->attitude_correlation_time = correlation_time(lags);
  }
  if (by_batch) {
    constexpr double kSolving = 0.5;  // part of the work
    const ProgressCallback report = stage("batch");
    const auto solved = options.batch(run.log, run.options, run.found, run.filtered, part_of(report, 0, kSolving));
    run.smoothed = solved->solution(part_of(report, kSolving, 1));
  }
  return run;
}

}  // namespace piste
