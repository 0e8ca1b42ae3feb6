#pragma once
/// Studies a campaign: from its logs to the errors of its IMUs by every method, and a ranking of the methods. Part of
/// piste::batch. docs/study.md is an introduction.
///
/// For each run, the reference IMU and its receiver give the reference solution. For each other IMU these steps follow:
/// the alignment (condition/time_sync), the phases of the run, the comparison of the signals (fit/imu_fit), the
/// GPS/MEMS filter with six models (filter_estimates), and the scale factors that residual timing errors would cause.
/// After all runs, navigation_score evaluates the navigation with each estimate.
///
/// A step that is not possible is left out, and the study reports it: a missing file, a sensor that saturates or a run
/// without standstill does not stop it.

#include <cstddef>
#include <functional>
#include <vector>

#include "piste/study/navigation_score.h"
#include "piste/study/study_config.h"
#include "piste/study/study_findings.h"

namespace piste {

/// Options of a study.
struct StudyOptions {
  std::vector<double> delays{0, 5e-3, 10e-3, 15e-3};  ///< residual timing errors to evaluate [s]
  OutagePlan outages;
  std::size_t jobs = 1;  ///< number of parallel runs; the result does not depend on it
};

/// Called with the number of steps done, from 0 on, and the number of all steps, by one thread at a time.
using StudyProgress = std::function<void(std::size_t, std::size_t)>;

/// Studies a campaign. Throws only what `progress` throws, and std::bad_alloc: faults of the data are part of the
/// result.
Study run_study(const StudyConfig& config, const StudyOptions& options, const StudyProgress& progress = {});

}  // namespace piste
