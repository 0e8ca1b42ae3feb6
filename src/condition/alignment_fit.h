#pragma once
/// The fit of an alignment to one pair of filtered signals, with the noise that the fit itself leaves.

#include <array>
#include <vector>

#include "alignment_problem.h"
#include "determination.h"
#include "paired_signals.h"
#include "whitening.h"

namespace piste {

/// 1-sigma of what a fit leaves of rates and forces, one axis: [0] of epochs at rest, [1] of epochs in motion.
struct ResidualNoise {
  std::array<double, 2> gyro{1, 1}, accel{1, 1};
};

/// What a fit found, and what it was found from.
struct AlignmentFit {
  AlignmentState x;
  ResidualNoise noise;                 ///< of what is left after the fit
  std::vector<AlignmentEpoch> epochs;  ///< with the sigmas that the last solution weighed them by
  AlignmentInformation information = AlignmentInformation::Zero();  ///< as solve_alignment returns it
};

/// What is left of rates and forces, one entry an epoch.
struct LeftOver {
  std::vector<Left> gyro, accel;
};

/// What is left of the epochs in motion, or of those at rest. An epoch of the other kind keeps its place, with no axis
/// usable, so that the entries stay equally spaced.
LeftOver left_over(const FilteredPair& pair, const AlignmentState& x, const std::vector<AlignmentEpoch>& epochs,
                   bool moving);

/// Solves twice over the epochs that both IMUs have in common at `start.x`, each time weighing by the noise that the
/// solution before left; the first time by `start.noise`.
AlignmentFit fit_alignment(const SignalPair& signals, const FilteredPair& pair, const ImuSensor& sensor,
                           const AlignmentFit& start);

/// As fit_alignment, on the signals of `pair` whitened by the spectrum of what `fit` left of them in motion. The
/// whitened pair is returned beside the fit.
struct WhitenedFit {
  FilteredPair pair;
  AlignmentFit fit;
};
WhitenedFit fit_whitened(const SignalPair& signals, const FilteredPair& pair, const ImuSensor& sensor,
                         const AlignmentFit& fit);

}  // namespace piste
