#include "piste/experiment/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "experiment/parallel.h"
#include "piste/condition/aligned_signals.h"
#include "piste/condition/pipeline.h"
#include "piste/condition/time_sync.h"
#include "piste/core/error.h"
#include "piste/experiment/filter_estimates.h"
#include "piste/experiment/reference_solution.h"
#include "piste/experiment/study_estimates.h"
#include "piste/experiment/timing_effect.h"
#include "piste/experiment/truth_file.h"
#include "piste/files/alignment.h"
#include "piste/solve/attitude_noise.h"

namespace piste {
namespace {

// What the ranking needs of an IMU in a run, once all runs are through.
struct Prepared {
  std::optional<Course> course;
  std::optional<KnownErrors> truth;
};

// What all IMUs of a run have in common.
struct RunData {
  std::vector<ImuSample> imu;  // of the reference
  GnssRecording gnss;
  std::optional<ReferenceSolution> solution;
};

// What a study can do without: where the data do not give it, the reason goes to the warnings.
template <class Part>
void unless_it_fails(std::string_view without, std::vector<std::string>& warnings, Part&& part) {
  try {
    part();
  } catch (const Error& e) {
    warnings.push_back(fmt::format("{}: {}", without, e.what()));
  }
}

RunData read_reference(const RunConfig& config, StudyRun& run) {
  RunData data;
  const ImuRecording recording = read_imu(config.reference.source);
  data.imu = condition_imu(recording, config.reference.conditioning).imu;
  unless_it_fails("no reference solution, and so neither filters nor navigation", run.warnings, [&] {
    if (!config.gnss) throw DataError("", "the run names no `gnss:`");
    data.gnss = read_gnss(config.gnss->log);
    data.solution = solve_reference(config, recording, data.gnss);
    run.sigma_attitude = data.solution->sigma_attitude;
    run.sigma_position = data.solution->sigma_position;
  });
  return data;
}

// The phases of which the IMU has enough; what it lacks is said.
Phases covered(const Phases& phases, const AlignedImus& imus, std::vector<std::string>& warnings) {
  constexpr double kEnough = 1;  // s
  const auto keep = [&](const std::optional<Interval>& phase, std::string_view name) -> std::optional<Interval> {
    if (!phase) {
      warnings.push_back(fmt::format("there is no {}", name));
      return std::nullopt;
    }
    double time = 0;
    for (std::size_t i = 0; i < imus.time.size(); ++i) {
      if (imus.usable[i] && phase->contains(imus.time[i])) time += imus.interval;
    }
    const double whole = phase->end - phase->start;
    if (time < 0.9 * whole) {
      warnings.push_back(fmt::format("{:.1f} of {:.1f} s of the {} are usable", time, whole, name));
    }
    return time >= std::min(kEnough, whole / 2) ? phase : std::nullopt;
  };
  return {keep(phases.before, "rest before the start"), keep(phases.run, "run"), keep(phases.after, "rest after it")};
}

SignalPicture picture(const AlignedImus& smooth, double low_pass) {
  constexpr double kPerPeriod = 2.5;  // samples of the cut-off
  const auto step = static_cast<std::size_t>(std::max(1.0, 1 / (kPerPeriod * low_pass * smooth.interval)));
  SignalPicture out;
  for (std::size_t i = 0; i < smooth.time.size(); i += step) {
    if (!smooth.usable[i]) continue;
    out.time.push_back(smooth.time[i]);
    for (int axis = 0; axis < kSignals; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const bool force = axis < 3;
      out.measured[a].push_back((force ? smooth.accel : smooth.gyro)[i](axis % 3));
      out.reference[a].push_back((force ? smooth.reference_accel : smooth.reference_gyro)[i](axis % 3));
    }
  }
  return out;
}

// How an IMU sits, and what its filter is told.
BodyMounting mounting_of(const Alignment& alignment) {
  BodyMounting body{alignment.q_rb, alignment.p_rb_r};
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(alignment.variance(AlignmentLayout::kLeverArm + i))) body.p_rb_r(i) = 0;
  }
  return body;
}

FilterCase filter_case(const RunConfig& config, const MountedImu& mems, const ImuRecording& recording,
                       const RunData& data, const Alignment& alignment, const Interval& run) {
  const BodyMounting body = mounting_of(alignment);
  FilterCase out{{}, {}, run};
  FilterOptions& options = out.options;
  options.sensor = mems.source.sensor;
  options.gnss = {config.gnss->options};
  Vector3d& arm = options.gnss.front().lever_arm;
  arm = body.q_rb.conjugate() * (arm - body.p_rb_r);
  options.attitude = {{.name = "reference", .drift = GaussMarkov{Vector3d::Zero(), data.solution->correlation_time}}};
  if (!(data.solution->correlation_time > 0)) options.attitude.front().drift.reset();
  options = with_attitude_sigmas(std::move(options), {data.solution->attitude});
  ConditioningOptions conditioning = mems.conditioning;
  conditioning.imu.clock_offset = alignment.clock_offset;
  conditioning.imu.clock_drift = alignment.clock_drift;
  conditioning.rest = options.rest;
  out.log = condition({recording, {data.gnss}, {data.solution->attitude}}, conditioning);
  return out;
}

void warn_of(const Alignment& alignment, const LogCounts& counts, std::size_t samples,
             std::vector<std::string>& warnings) {
  for (const std::string& what : alignment.undetermined) warnings.push_back("not determined: " + what);
  warnings.insert(warnings.end(), alignment.warnings.begin(), alignment.warnings.end());
  if (counts.imu_gaps > 0) warnings.push_back(fmt::format("{} gaps in the log", counts.imu_gaps));
  if (counts.imu_clipped > 0) {
    warnings.push_back(fmt::format("{} of {} samples stand at the sensor's range, and are left out of the comparisons",
                                   counts.imu_clipped, samples));
  }
}

// One IMU of a run, all but the ranking.
void study_imu(const RunConfig& config, const MountedImu& mems, const RunData& data, const StudyConfig& study,
               const StudyOptions& options, StudyRun& run, SensorRun& out, Prepared& prepared) {
  const ImuRecording recording = read_imu(mems.source);
  const Log body = condition_imu(recording, mems.conditioning);
  const ImuSensor& reference = config.reference.source.sensor;
  const Alignment alignment = align(
      body.imu, data.imu,
      {.sensor = mems.source.sensor, .reference = reference, .low_pass = study.low_pass, .name = mems.source.log.file});
  warn_of(alignment, body.counts, recording.time.size(), out.warnings);
  out.clock_offset = alignment.clock_offset;
  out.clock_drift = alignment.clock_drift;
  out.boresight = to_euler(alignment.q_rb);
  out.sigma_boresight = boresight_sigma(alignment);
  out.lever_arm = alignment.p_rb_r;

  const AlignedImus aligned = bring_together(body.imu, data.imu, alignment);
  const AlignedImus smooth = low_passed(aligned, study.low_pass);
  if (!run.phases.before && !run.phases.run && !run.phases.after) {
    run.phases = config.phases ? *config.phases : phases(aligned, study.low_pass);
    out.picture = picture(smooth, study.low_pass);
  }
  const Phases own = covered(run.phases, smooth, out.warnings);
  out.findings = findings(
      aligned, own,
      {.low_pass = study.low_pass, .alignment = &alignment, .reference = &reference, .sensor = &mems.source.sensor});
  out.estimates = signal_estimates(*out.findings);
  if (own.run) {
    for (const double delay : options.delays) {
      Alignment late = alignment;
      late.clock_offset += delay;
      out.timing.push_back(
          timing_effect(low_passed(bring_together(body.imu, data.imu, late), study.low_pass), *own.run, delay));
    }
  }
  if (data.solution && own.run) {
    unless_it_fails("neither filters nor navigation", out.warnings, [&] {
      const FilterCase filter = filter_case(config, mems, recording, data, alignment, *own.run);
      std::vector<MethodEstimate> more = filter_estimates(filter, out.warnings);
      out.estimates.insert(out.estimates.end(), more.begin(), more.end());
      prepared.course.emplace(filter.log, filter.options, *own.run, data.solution->track, mounting_of(alignment),
                              options.outages);
      run.outages = prepared.course->windows();
    });
  }
  if (config.truth) {
    unless_it_fails("what was put in is not known", out.warnings, [&] {
      const ImuTruth truth = read_truth(*config.truth, std::filesystem::path(mems.source.log.file).stem().string());
      for (MethodEstimate& estimate : out.estimates) hold_against(truth, estimate);
      prepared.truth = known_errors(truth);
    });
  }
}

// All of a run but the ranking. Errors of the data become words.
template <class Step>
void study_run(const RunConfig& config, const StudyConfig& study, const StudyOptions& options, StudyRun& run,
               std::span<SensorRun> imus, std::span<Prepared> prepared, Step&& step) {
  std::optional<RunData> data;
  try {
    data = read_reference(config, run);
  } catch (const Error& e) {
    run.failure = e.what();
  }
  step();
  for (std::size_t i = 0; i < imus.size(); ++i) {
    try {
      if (!data) throw DataError("", "the run has no reference");
      study_imu(config, config.mems[i], *data, study, options, run, imus[i], prepared[i]);
    } catch (const Error& e) {
      imus[i].failure = e.what();
    }
    step();
  }
}

void rank(SensorRun& result, const Prepared& prepared) {
  if (!prepared.course) return;
  const auto add = [&](Method method, const std::optional<KnownErrors>& errors) {
    try {
      result.scores.push_back(prepared.course->score(method, errors));
    } catch (const Error& e) {
      result.warnings.push_back(fmt::format("{} cannot be replayed: {}", info(method).title, e.what()));
    }
  };
  add(Method::kNothing, KnownErrors{});
  for (const MethodEstimate& estimate : result.estimates) {
    add(estimate.method, known_errors(estimate, result.findings));
  }
  add(Method::kInTheFilter, std::nullopt);
  if (prepared.truth) add(Method::kTruth, prepared.truth);
}

// Place of the IMU's name in the list, to which it is added where it is new.
std::size_t place_of(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}

}  // namespace

Study run_study(const StudyConfig& config, const StudyOptions& options, const StudyProgress& progress) {
  Study study;
  study.name = config.file.stem().string();
  study.low_pass = config.low_pass;
  std::vector<std::size_t> first;  // result of each run
  for (const RunConfig& run : config.runs) {
    study.simulated = study.simulated || run.truth.has_value();
    first.push_back(study.results.size());
    for (const MountedImu& mems : run.mems) {
      SensorRun result;
      result.run = study.runs.size();
      result.sensor = place_of(study.sensors, mems.name);
      study.results.push_back(std::move(result));
    }
    StudyRun out;
    out.name = run.name;
    out.activity = run.activity;
    study.runs.push_back(std::move(out));
  }

  const std::size_t total = study.runs.size() + 2 * study.results.size();
  std::mutex mutex;
  std::size_t done = 0;
  const auto step = [&] {
    const std::lock_guard lock(mutex);
    if (progress) progress(++done, total);
  };
  if (progress) progress(0, total);
  std::vector<Prepared> prepared(study.results.size());
  for_each_parallel(study.runs.size(), options.jobs, [&](std::size_t i) {
    const std::size_t count = config.runs[i].mems.size();
    study_run(config.runs[i], config, options, study.runs[i], std::span(study.results).subspan(first[i], count),
              std::span(prepared).subspan(first[i], count), step);
  });
  add_other_runs(study);
  for_each_parallel(study.results.size(), options.jobs, [&](std::size_t i) {
    rank(study.results[i], prepared[i]);
    step();
  });
  return study;
}

}  // namespace piste
