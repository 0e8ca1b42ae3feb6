#include "piste/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "math/parallel.h"
#include "piste/core/error.h"
#include "study/study_as_one.h"
#include "study/study_estimates.h"
#include "study/study_imu.h"

namespace piste {
namespace {

// A run and its IMUs, without the ranking.
struct StudiedRun {
  StudyRun run;
  std::vector<StudiedImu> imus;
  std::optional<StudiedImu> as_one;  // the fused IMU, if there are several
};

bool has_several(const RunConfig& run) { return run.mems.size() > 1; }

// Errors of the data are kept as messages. `step` is called after the reference, after each IMU, and after the fused
// IMU.
template <class Step>
StudiedRun study_run(const RunConfig& config, const StudyPlan& plan, Step&& step) {
  StudiedRun out;
  out.run.name = config.name;
  out.run.activity = config.activity;
  std::optional<RunReference> reference;
  try {
    reference = read_reference(config);
    out.run.warnings = reference->warnings;
    if (const auto& solution = reference->solution) {
      out.run.sigma_attitude = solution->sigma_attitude;
      out.run.sigma_position = solution->sigma_position;
    }
  } catch (const Error& e) {
    out.run.failure = e.what();
  }
  step();
  for (const MountedImu& mems : config.mems) {
    StudiedImu imu;
    if (reference) {
      imu = study_imu(config, *reference, mems, out.run.phases, plan);
      out.run.phases = imu.phases;
      if (imu.contest.course) out.run.outages = imu.contest.course->windows();
    } else {
      imu.result.failure = DataError("", "the run has no reference").what();
    }
    out.imus.push_back(std::move(imu));
    step();
  }
  if (has_several(config)) {
    if (reference) out.as_one = study_as_one(config, *reference, out.imus, out.run.phases, plan);
    step();
  }
  for (StudiedImu& imu : out.imus) imu.aligned.reset();  // large, and not needed any more
  return out;
}

// The scores of all methods, and messages for those that cannot be replayed.
struct Scores {
  std::vector<NavigationScore> scores;
  std::vector<std::string> warnings;
};

// The fused IMU competes with the single IMUs only by the replay that estimates its errors.
Scores score_as_one(const Contest& contest) {
  Scores out;
  if (!contest.course) return out;
  try {
    out.scores.push_back(contest.course->score(Method::kInTheFilter, std::nullopt));
  } catch (const Error& e) {
    out.warnings.push_back(fmt::format("they cannot be replayed: {}", e.what()));
  }
  return out;
}

Scores score(const SensorRun& imu, const Contest& contest) {
  Scores out;
  if (!contest.course) return out;
  const auto add = [&](Method method, const std::optional<KnownErrors>& errors) {
    try {
      out.scores.push_back(contest.course->score(method, errors));
    } catch (const Error& e) {
      out.warnings.push_back(fmt::format("{} cannot be replayed: {}", info(method).title, e.what()));
    }
  };
  add(Method::kNothing, KnownErrors{});
  for (const MethodEstimate& estimate : imu.estimates) {
    add(estimate.method, known_errors(estimate, imu.findings));
  }
  add(Method::kInTheFilter, std::nullopt);
  if (contest.truth) add(Method::kTruth, contest.truth);
  return out;
}

// Index of the IMU's name in the list; adds a new name.
std::size_t place_of(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}

// The study of all runs, without scores.
Study gather(const StudyConfig& config, const std::vector<StudiedRun>& studied) {
  Study study;
  study.name = config.file.stem().string();
  study.low_pass = config.low_pass;
  study.article = config.article;
  for (std::size_t run = 0; run < studied.size(); ++run) {
    study.simulated = study.simulated || config.runs[run].truth.has_value();
    study.runs.push_back(studied[run].run);
    for (std::size_t i = 0; i < studied[run].imus.size(); ++i) {
      SensorRun& result = study.results.emplace_back(studied[run].imus[i].result);
      result.run = run;
      result.sensor = place_of(study.sensors, config.runs[run].mems[i].name);
    }
    if (studied[run].as_one) {
      study.as_one.push_back(studied[run].as_one->result);
      study.as_one.back().run = run;
    }
  }
  return study;
}

}  // namespace

Study run_study(const StudyConfig& config, const StudyOptions& options, const StudyProgress& progress) {
  const StudyPlan plan{config.low_pass, options.delays, options.outages};
  std::size_t total = config.runs.size(), done = 0;
  for (const RunConfig& run : config.runs) total += 2 * (run.mems.size() + (has_several(run) ? 1 : 0));
  std::mutex mutex;
  const auto step = [&] {
    const std::lock_guard lock(mutex);
    if (progress) progress(++done, total);
  };
  if (progress) progress(0, total);
  std::vector<StudiedRun> studied(config.runs.size());
  for_each_parallel(studied.size(), options.jobs,
                    [&](std::size_t i) { studied[i] = study_run(config.runs[i], plan, step); });

  Study study = gather(config, studied);
  add_other_runs(study);
  struct Scored {
    SensorRun* result;
    const Contest* contest;
    bool as_one;
  };
  std::vector<Scored> all;
  std::size_t next = 0, next_as_one = 0;
  for (const StudiedRun& run : studied) {
    for (const StudiedImu& imu : run.imus) all.push_back({&study.results[next++], &imu.contest, false});
    if (run.as_one) all.push_back({&study.as_one[next_as_one++], &run.as_one->contest, true});
  }
  for_each_parallel(all.size(), options.jobs, [&](std::size_t i) {
    SensorRun& result = *all[i].result;
    Scores found = all[i].as_one ? score_as_one(*all[i].contest) : score(result, *all[i].contest);
    result.scores = std::move(found.scores);
    std::move(found.warnings.begin(), found.warnings.end(), std::back_inserter(result.warnings));
    step();
  });
  return study;
}

}  // namespace piste
