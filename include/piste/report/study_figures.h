#pragma once
/// What a study looks like, as figures.
///
/// Biases and scales are corrections to add: true = (1 + scale') measured + bias'.
/// Bars are 95 % intervals of the mean over the runs, and captions say of how many. What a study does not have has no
/// figure.

#include <vector>

#include "piste/experiment/study_findings.h"
#include "piste/plot/figure.h"

namespace piste {

/// Figure 7: the whole signal of one IMU beside the reference, with the three phases. Figures 9 and 10: the difference
/// at rest before and after.
std::vector<Figure> study_signals(const Study& study);
/// Figures 8 (at rest), 13 and 14 (in the run) of the biases, 15 of the scales; sensors side by side.
std::vector<Figure> study_estimates(const Study& study);
/// Figures 16 and 17: biases from the comparison of the signals beside those of the filter.
std::vector<Figure> study_comparisons(const Study& study);
/// Table 5 as colours: correlation of bias and scale.
std::vector<Figure> study_correlations(const Study& study);
/// Every method's estimates less what was put in. Empty unless the campaign is simulated.
std::vector<Figure> study_truth(const Study& study);
/// Scales over a delay of the reference, with the mean scales of the article that the campaign names.
std::vector<Figure> study_timing(const Study& study);
/// Scores of the methods with their intervals, and the four errors that make them.
std::vector<Figure> study_ranking(const Study& study);

/// All of them, in that order.
std::vector<Figure> study_figures(const Study& study);

}  // namespace piste
