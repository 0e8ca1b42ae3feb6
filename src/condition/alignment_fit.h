#pragma once
/// Fits an alignment to a pair of filtered signals. The weights come from the residuals of the fit itself.

#include <array>
#include <vector>

#include "alignment_problem.h"
#include "determination.h"
#include "paired_signals.h"
#include "whitening.h"

namespace piste {

/// 1-sigma of the residuals of rates and forces, of one axis: [0] at rest, [1] in motion.
struct ResidualNoise {
  std::array<double, 2> gyro{1, 1}, accel{1, 1};
};

/// The result of a fit, and the epochs that it used.
struct AlignmentFit {
  AlignmentState x;
  ResidualNoise noise;                                              ///< of the residuals of the fit
  std::vector<AlignmentEpoch> epochs;                               ///< with the sigmas of the last solution
  AlignmentInformation information = AlignmentInformation::Zero();  ///< as solve_alignment returns it
};

/// Residuals of rates and forces, one entry for each epoch.
struct LeftOver {
  std::vector<Left> gyro, accel;
};

/// Residuals of the epochs in motion, or of those at rest. An epoch of the other kind has an entry without usable axes,
/// so that the entries stay equally spaced.
LeftOver left_over(const FilteredPair& pair, const AlignmentState& x, const std::vector<AlignmentEpoch>& epochs,
                   bool moving);

/// Solves the least-squares problem twice, over the epochs that both IMUs have in common at `start.x`. The first time
/// the weights come from `start.noise`, the second time from the residuals of the first.
AlignmentFit fit_alignment(const SignalPair& signals, const FilteredPair& pair, const ImuSensor& sensor,
                           const AlignmentFit& start);

/// A fit to whitened signals, these signals, and what whitened rates and forces.
struct WhitenedFit {
  FilteredPair pair;
  AlignmentFit fit;
  Whitening gyro, accel;
};
/// The same as fit_alignment, on the signals of `pair` after whitening by the spectrum of the residuals of `fit` in
/// motion.
WhitenedFit fit_whitened(const SignalPair& signals, const FilteredPair& pair, const ImuSensor& sensor,
                         const AlignmentFit& fit);

}  // namespace piste
