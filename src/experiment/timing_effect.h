#pragma once
/// Scale factors that a residual timing error makes.
///
/// Two signals that are the same but for a delay d correlate less than wholly, and a regression of one on the other is
/// flat by Σ S(f) (1 − cos 2πfd) / Σ S(f), S being their spectrum: a scale factor out of nothing, negative as a
/// correction, and the larger the livelier the motion.

#include "piste/core/aligned.h"
#include "piste/experiment/study_findings.h"

namespace piste {

/// Scale factors in the run by both regressions, reference on IMU (inverted) and IMU on reference. `imus` are signals
/// whose reference comes late by `delay` [s], after the low-pass.
/// Throws DataError where the run has too few samples, or an axis has no motion.
TimingEffect timing_effect(const AlignedImus& imus, const Interval& run, double delay);

}  // namespace piste
