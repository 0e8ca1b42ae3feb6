#pragma once
/// Converts the findings of one IMU in one run into the estimates that a study compares, and these estimates into the
/// errors that a replay subtracts. Adds the true values if they are known.

#include <optional>
#include <vector>

#include "piste/model/known_errors.h"
#include "piste/study/study_findings.h"
#include "study/truth_file.h"

namespace piste {

/// The estimates of every method that compares signals, if the findings have them.
std::vector<MethodEstimate> signal_estimates(const Findings& findings);

/// The errors that a replay subtracts for an estimate. Axes without an estimate have no errors. For kPolynomial and
/// kMisalignment it is the whole model from `findings`. @pre `findings` has that model
KnownErrors known_errors(const MethodEstimate& estimate, const std::optional<Findings>& findings);

/// The same for the truth: turn-on bias plus mean drift of the run, scale and misalignment. Without a run, the drift of
/// the rest before it is used.
KnownErrors known_errors(const ImuTruth& truth);

/// Of the errors that a triad adds to the true signal, the part proportional to the signal: (1 + scale) M − 1.
Matrix3d gain_of(const ImuTruth::Triad& truth);

/// Sets the true values of the quantities that the method estimates. For a bias alone this is bias + drift + (scale and
/// misalignment) · mean true signal of its phase. For a line it is bias + mean drift of the run (for kScaleOnly: of the
/// rest through which the line passes), and scale.
void hold_against(const ImuTruth& truth, MethodEstimate& estimate);

/// Adds Method::kOtherRuns to every result, of single and fused IMUs, that has a rest before, and whose IMU has at
/// least two other runs with kJointBothNoisy. The scale's sigma is that of a prediction, std · √(1 + 1/n) over these
/// runs.
void add_other_runs(Study& study);

}  // namespace piste
