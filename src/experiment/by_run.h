#pragma once
/// Numbers of IMUs in runs, over the IMUs of each run: all IMUs of a run share its motion and its reference.

#include <vector>

#include "piste/experiment/study_findings.h"

namespace piste {

/// Mean over the sensors of each run, in the order of the runs. `values` are of `at`, one each.
std::vector<double> mean_by_run(const std::vector<const SensorRun*>& at, const std::vector<double>& values);

}  // namespace piste
