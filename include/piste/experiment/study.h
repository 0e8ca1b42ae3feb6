#pragma once
/// A campaign, from logs to what it taught. In piste::batch.
///
/// For each run the reference IMU and its receiver give the reference solution. For each IMU beside it: alignment
/// (condition/time_sync), phases of the run, comparison of the signals (fit/imu_fit), the GPS/MEMS filter by six
/// models (filter_estimates), scale factors that residual timing errors would make, and, once all runs are through, the
/// navigation that each estimate leads to (navigation_score).
///
/// What cannot be done is left out, and said: a campaign with a missing file, a sensor that saturates, a run without
/// rest is studied as far as it goes.

#include <cstddef>
#include <functional>
#include <vector>

#include "piste/experiment/navigation_score.h"
#include "piste/experiment/study_config.h"
#include "piste/experiment/study_findings.h"

namespace piste {

struct StudyOptions {
  std::vector<double> delays{0, 5e-3, 10e-3, 15e-3};  ///< residual timing errors that are tried [s]
  OutagePlan outages;
  std::size_t jobs = 1;  ///< runs at a time; the result does not depend on it
};

/// Called with the steps done and those that there are, from 0 on, by one thread at a time.
using StudyProgress = std::function<void(std::size_t, std::size_t)>;

/// Throws only what `progress` throws, and std::bad_alloc; what is wrong with the data stands in the study.
Study run_study(const StudyConfig& config, const StudyOptions& options, const StudyProgress& progress = {});

}  // namespace piste
