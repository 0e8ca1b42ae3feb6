#pragma once
/// Computes the scale factors that a residual timing error causes.
///
/// Two signals that are equal except for a delay d do not correlate fully. The slope of a regression of one on the
/// other is too small by Σ S(f) (1 − cos 2πfd) / Σ S(f), with their spectrum S. This looks like a scale factor. As a
/// correction it is negative, and it is larger in faster motion. Example: a sine of 1 Hz and d = 10 ms give
/// 1 − cos 0.0628 = 0.0020, so the slope is 0.2 % too small.

#include "piste/core/aligned.h"
#include "piste/study/study_findings.h"

namespace piste {

/// The scale factors in the run by both regressions, reference on IMU (inverted) and IMU on reference. @pre the
/// reference in `imus` is late by `delay` [s], and both signals are low-passed.
/// Throws DataError if the run has too few samples, or an axis has no motion.
TimingEffect timing_effect(const AlignedImus& imus, const Interval& run, double delay);

}  // namespace piste
