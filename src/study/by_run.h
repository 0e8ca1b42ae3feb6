#pragma once
/// Averages numbers over the IMUs of each run, because IMUs of a run share its motion and reference and are not
/// independent.

#include <vector>

#include "piste/study/study_findings.h"

namespace piste {

/// The mean over the sensors of each run, in the order of the runs. `values` has one value for each element of `at`.
std::vector<double> mean_by_run(const std::vector<const SensorRun*>& at, const std::vector<double>& values);

}  // namespace piste
