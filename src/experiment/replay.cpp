#include "piste/experiment/replay.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/solve/attitude_noise.h"
#include "piste/solve/look_back.h"
#include "piste/solve/relinearise.h"
#include "piste/solve/rts.h"
#include "piste/solve/vehicle_mounting.h"

namespace piste {
namespace {

template <class Sources>
void check_sources(const Sources& sources, const FilterOptions& options) {
  const auto check = [](std::string_view kind, std::size_t there, std::size_t told) {
    if (there == told) return;
    throw ConfigError("filter options",
                      fmt::format("{}: options of {} sources for {}; one each is needed", kind, told, there));
  };
  check("gnss", sources.gnss.size(), options.gnss.size());
  check("attitude", sources.attitude.size(), options.attitude.size());
}

// The log of a recording; the sigmas of its attitudes become known to the options.
Log conditioned(const Recording& recording, ReplayOptions& options) {
  check_sources(recording, options.filter);
  options.filter = with_attitude_sigmas(std::move(options.filter), recording.attitude);
  return condition(recording, options.conditioning);
}

}  // namespace

ReplayOptions replay_options(const ReplayConfig& config) {
  return {.conditioning = config.conditioning,
          .filter = config.filter,
          .heading = config.initial,
          .smoother = config.smoother,
          .checkpoints = false};
}

Replay replay(const ReplayConfig& config, const ReplayProgress& progress, const BatchSolver& batch) {
  ReplayOptions options = replay_options(config);
  options.batch = batch;
  Log log;
  {
    const Recording recording = read_recording(config);  // its rows are not needed once the log is made
    log = conditioned(recording, options);
  }
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
  run.found = options.start ? FoundStart{*options.start, "the start was given"}
                            : find_start(run.log, run.options, options.heading);
  run.options = with_mounting(std::move(run.options), run.log, run.found.start);
  const Start& start = run.found.start;
  const bool smooth = options.smoother == SmootherKind::kRts;
  const int checkpoint_every = smooth || options.checkpoints ? kCheckpointEvery : 0;
  run.filtered =
      run_filter(run.log, run.options, start, checkpoint_every, stage("filter"), start.time + options.longest);
  look_back(run.log, run.options, run.found, run.filtered.solution);
  if (smooth) {
    std::vector<AttitudeLag> lags;
    for (int pass = 0; pass < options.relinearisations; ++pass) {
      run.relinearised = relinearised(run.log, run.options, run.found, run.smoothable(), stage("relinearising"));
    }
    run.smoothed = smooth_rts(run.log, run.smoothable(), stage("smoother"), nullptr, &lags);
    run.smoothed->attitude_correlation_time = correlation_time(lags);
  }
  if (by_batch) {
    constexpr double kSolving = 0.5;  // part of the work
    const ProgressCallback told = stage("batch");
    const auto solved = options.batch(run.log, run.options, run.found, run.filtered, part_of(told, 0, kSolving));
    run.smoothed = solved->solution(part_of(told, kSolving, 1));
  }
  return run;
}

}  // namespace piste
