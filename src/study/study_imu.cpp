#include "study/study_imu.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>

#include "piste/condition/aligned_signals.h"
#include "piste/condition/pipeline.h"
#include "piste/condition/time_sync.h"
#include "piste/core/error.h"
#include "piste/start/attitude_noise.h"
#include "study/filter_estimates.h"
#include "study/study_estimates.h"
#include "study/timing_effect.h"
#include "study/truth_file.h"

namespace piste {
namespace {

// An optional part of a study. If it fails, the result is nothing, and the reason becomes a warning.
template <class Part>
auto if_possible(std::string_view without, std::vector<std::string>& warnings, Part&& part)
    -> std::optional<decltype(part())> {
  try {
    return part();
  } catch (const Error& e) {
    warnings.push_back(fmt::format("{}: {}", without, e.what()));
    return std::nullopt;
  }
}

ReferencedImu align_with_reference(const RunConfig& run, const RunReference& reference, const MountedImu& imu,
                                   double low_pass) {
  ReferencedImu out{.sensor = turned(imu.source.sensor, imu.source.conditioning.R_bs),
                    .imus = {},
                    .recording = {.imu = read_imu(imu.source), .gnss = {}, .attitude = {}},
                    .conditioning = imu.conditioning,
                    .log = {},
                    .alignment = {}};
  out.log = condition_imu(out.recording.imu, imu.conditioning);
  out.alignment = align(out.log.imu, reference.imu,
                        {.sensor = imu.source.sensor,
                         .reference = run.reference.source.sensor,
                         .low_pass = low_pass,
                         .name = imu.source.log.file});
  out.conditioning.imu.clock_offset = out.alignment.clock_offset;
  out.conditioning.imu.clock_drift = out.alignment.clock_drift;
  return out;
}

std::vector<std::string> warnings_of(const ReferencedImu& imu) {
  const Alignment& alignment = imu.alignment;
  const LogCounts& counts = imu.log.counts;
  std::vector<std::string> out;
  for (const std::string& what : alignment.undetermined) out.push_back("not determined: " + what);
  out.insert(out.end(), alignment.warnings.begin(), alignment.warnings.end());
  if (counts.imu_gaps > 0) out.push_back(fmt::format("{} gaps in the log", counts.imu_gaps));
  if (counts.imu_clipped > 0) {
    out.push_back(fmt::format("{} of {} samples stand at the sensor's range, and are left out of the comparisons",
                              counts.imu_clipped, imu.recording.imu.time.size()));
  }
  if (counts.imu_spikes > 0) {
    out.push_back(fmt::format("{} of {} samples hold a spike, and are left out of the comparisons", counts.imu_spikes,
                              imu.recording.imu.time.size()));
  }
  return out;
}

// The result of an IMU with its place in the study only.
SensorRun placed(const ReferencedImu& imu) {
  SensorRun out;
  out.warnings = warnings_of(imu);
  out.clock_offset = imu.alignment.clock_offset;
  out.clock_drift = imu.alignment.clock_drift;
  out.boresight = to_euler(imu.alignment.q_rb);
  out.sigma_boresight = imu.alignment.boresight_sigma();
  out.lever_arm = imu.alignment.p_rb_r;
  return out;
}

// The signals of an IMU and of the reference, as they are compared.
AlignedImus compared(const ReferencedImu& imu, const RunReference& reference, double low_pass) {
  AlignedImus out = low_passed(bring_together(imu.log.imu, reference.imu, imu.alignment), low_pass);
  if (imu.imus.empty()) return out;
  for (std::size_t i = 0; i < out.time.size(); ++i) {
    out.accel[i] -= imu.across_accel * out.reference_accel[i];
    out.gyro[i] -= imu.across_gyro * out.reference_gyro[i];
  }
  return out;
}

// The phases in which the IMU has enough samples, and warnings for the others.
struct Covered {
  Phases phases;
  std::vector<std::string> warnings;
};

Covered covered(const Phases& phases, const AlignedImus& imus) {
  constexpr double kEnough = 1;  // s
  Covered out;
  const auto keep = [&](const std::optional<Interval>& phase, std::string_view name) -> std::optional<Interval> {
    if (!phase) {
      out.warnings.push_back(fmt::format("there is no {}", name));
      return std::nullopt;
    }
    double time = 0;
    for (std::size_t i = 0; i < imus.time.size(); ++i) {
      if (imus.usable[i] && phase->contains(imus.time[i])) time += imus.interval;
    }
    const double whole = phase->end - phase->start;
    if (time < 0.9 * whole) {
      out.warnings.push_back(fmt::format("{:.1f} of {:.1f} s of the {} are usable", time, whole, name));
    }
    return time >= std::min(kEnough, whole / 2) ? phase : std::nullopt;
  };
  out.phases.before = keep(phases.before, "rest before the start");
  out.phases.run = keep(phases.run, "run");
  out.phases.after = keep(phases.after, "rest after it");
  return out;
}

SignalPicture picture(const AlignedImus& smooth) {
  constexpr double kPerPeriod = 2.5;  // samples per period of the cut-off
  const auto step = static_cast<std::size_t>(std::max(1.0, 1 / (kPerPeriod * smooth.low_pass * smooth.interval)));
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

// Scale factors that residual timing errors cause.
std::vector<TimingEffect> timing_effects(const ReferencedImu& imu, const RunReference& reference, const Interval& run,
                                         const StudyPlan& plan) {
  std::vector<TimingEffect> out;
  for (const double delay : plan.delays) {
    Alignment late = imu.alignment;
    late.clock_offset += delay;
    const AlignedImus signals = bring_together(imu.log.imu, reference.imu, late);
    out.push_back(timing_effect(low_passed(signals, plan.low_pass), run, delay));
  }
  return out;
}

// The mounting of an IMU.
BodyMounting mounting_of(const Alignment& alignment) {
  return {alignment.q_rb, alignment.known(alignment.p_rb_r, AlignmentLayout::kLeverArm)};
}

// The input of the filter of an IMU.
FilterCase filter_case(const RunConfig& config, const RunReference& reference, const ReferencedImu& imu,
                       const Interval& run) {
  const ReferenceSolution& solution = *reference.solution;
  const BodyMounting body = mounting_of(imu.alignment);
  FilterCase out{{}, {}, run};
  FilterOptions& options = out.options;
  options.sensor = imu.sensor;
  options.imus = imu.imus;
  for (const FusedImuConditioning& unit : imu.conditioning.imus) options.unit_axes.push_back(unit.imu.R_bs);
  options.gnss = {config.gnss->options};
  Vector3d& arm = options.gnss.front().lever_arm;
  arm = body.q_rb.conjugate() * (arm - body.p_rb_r);
  options.attitude = {{.name = "reference", .drift = GaussMarkov{Vector3d::Zero(), solution.correlation_time}}};
  if (!(solution.correlation_time > 0)) options.attitude.front().drift.reset();
  options = with_attitude_sigmas(std::move(options), {solution.attitude});
  ConditioningOptions conditioning = imu.conditioning;
  conditioning.behaviour = options.behaviour;
  Recording recording = imu.recording;
  recording.gnss = {reference.gnss};
  recording.attitude = {solution.attitude};
  out.log = condition(std::move(recording), conditioning);
  return out;
}

// The filter's estimates for an IMU, and the course on which all methods are ranked.
struct Navigated {
  std::vector<MethodEstimate> estimates;
  std::optional<Course> course;
  std::vector<std::string> warnings;
};

Navigated navigate(const RunConfig& run, const RunReference& reference, const ReferencedImu& imu, const Interval& phase,
                   const OutagePlan& outages) {
  Navigated out;
  const auto filter = if_possible("neither filters nor navigation", out.warnings,
                                  [&] { return filter_case(run, reference, imu, phase); });
  if (!filter) return out;
  out.estimates = filter_estimates(*filter, out.warnings);
  out.course = if_possible("no navigation", out.warnings, [&] {
    return Course(filter->log, filter->options, phase, reference.solution->track, mounting_of(imu.alignment), outages);
  });
  return out;
}

template <class T>
void append(std::vector<T>& to, std::vector<T> more) {
  std::move(more.begin(), more.end(), std::back_inserter(to));
}

bool any(const Phases& phases) { return phases.before || phases.run || phases.after; }

}  // namespace

RunReference read_reference(const RunConfig& run) {
  RunReference out;
  const ImuRecording recording = read_imu(run.reference.source);
  out.imu = condition_imu(recording, run.reference.conditioning).imu;
  out.solution = if_possible("no reference solution, and so neither filters nor navigation", out.warnings, [&] {
    if (!run.gnss) throw DataError("", "the run names no `gnss:`");
    out.gnss = read_gnss(run.gnss->log);
    return solve_reference(run, recording, out.gnss);
  });
  return out;
}

void study_aligned(const RunConfig& run, const RunReference& reference, const ReferencedImu& imu, const Phases& known,
                   const StudyPlan& plan, StudiedImu& out) {
  SensorRun& result = out.result;
  const AlignedImus smooth = compared(imu, reference, plan.low_pass);
  if (!any(known)) {
    out.phases = run.phases ? *run.phases : phases(smooth);
    result.picture = picture(smooth);
  }
  const Covered own = covered(out.phases, smooth);
  append(result.warnings, own.warnings);
  result.findings =
      findings(smooth, own.phases,
               {.alignment = &imu.alignment, .reference = &run.reference.source.sensor, .sensor = &imu.sensor});
  result.estimates = signal_estimates(*result.findings);
  if (own.phases.run && imu.imus.empty()) result.timing = timing_effects(imu, reference, *own.phases.run, plan);
  if (!own.phases.run || !reference.solution) return;
  Navigated found = navigate(run, reference, imu, *own.phases.run, plan.outages);
  append(result.warnings, std::move(found.warnings));
  append(result.estimates, std::move(found.estimates));
  out.contest.course = std::move(found.course);
}

void hold_against_truth(const ImuTruth& truth, StudiedImu& out) {
  for (MethodEstimate& estimate : out.result.estimates) hold_against(truth, estimate);
  out.contest.truth = known_errors(truth);
  out.truth = truth;
}

StudiedImu study_imu(const RunConfig& run, const RunReference& reference, const MountedImu& mounted,
                     const Phases& known, const StudyPlan& plan) {
  StudiedImu out;
  SensorRun& result = out.result;
  out.phases = known;
  try {
    out.aligned = align_with_reference(run, reference, mounted, plan.low_pass);
    result = placed(*out.aligned);
    study_aligned(run, reference, *out.aligned, known, plan, out);
    if (!run.truth) return out;
    const auto truth = if_possible("what was put in is not known", result.warnings, [&] {
      return read_truth(*run.truth, std::filesystem::path(mounted.source.log.file).stem().string());
    });
    if (truth) hold_against_truth(*truth, out);
  } catch (const Error& e) {
    result.failure = e.what();
  }
  return out;
}

}  // namespace piste
