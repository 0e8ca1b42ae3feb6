#pragma once
/// From the findings of one IMU in one run to the estimates that a study compares; what a replay is told of them; and
/// what was put in, where that is known.

#include <optional>
#include <vector>

#include "experiment/truth_file.h"
#include "piste/experiment/study_findings.h"
#include "piste/model/known_errors.h"

namespace piste {

/// Every method that compares signals, as far as the findings have it.
std::vector<MethodEstimate> signal_estimates(const Findings& findings);

/// What a replay is to take for known. Axes without an estimate are taken for free of errors. Of kPolynomial and
/// kMisalignment the whole model, from `findings`, which must have it.
KnownErrors known_errors(const MethodEstimate& estimate, const std::optional<Findings>& findings);

/// The same of the truth: turn-on bias and mean drift of the run, scale and misalignment. Without a run, the drift
/// before it.
KnownErrors known_errors(const ImuTruth& truth);

/// Sets what was put in, as the method could see it: a bias alone is bias + drift + (scale and misalignment) · the mean
/// true signal of its phase; of a line, bias + mean drift of the run (of kScaleOnly, of the rest that it goes through)
/// and scale.
void hold_against(const ImuTruth& truth, MethodEstimate& estimate);

/// Adds Method::kOtherRuns to every result that has a rest before, and whose IMU has two other runs with
/// kJointBothNoisy: the scale's sigma is that of a prediction, std · √(1 + 1/n) between the runs.
void add_other_runs(Study& study);

}  // namespace piste
