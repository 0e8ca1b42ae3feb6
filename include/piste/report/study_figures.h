#pragma once
/// Figures of a study.
///
/// Biases and scales are corrections to add: true = (1 + scale') measured + bias'. Bars are 95 % intervals of the mean
/// over the runs; captions state the number of runs. A figure without data in a study is left out.

#include <vector>

#include "piste/plot/figure.h"
#include "piste/study/study_findings.h"

namespace piste {

/// Figure 7: the whole signal of one IMU with the reference, and the three phases. Figures 9 and 10: the difference at
/// rest before and after.
std::vector<Figure> study_signals(const Study& study);
/// Figures 8 (at rest), 13 and 14 (in the run) of the biases, 15 of the scales; sensors side by side.
std::vector<Figure> study_estimates(const Study& study);
/// Figures 16 and 17: biases from the comparison of the signals, next to the biases from the filter.
std::vector<Figure> study_comparisons(const Study& study);
/// Table 5 as colours: correlation of bias and scale.
std::vector<Figure> study_correlations(const Study& study);
/// The errors of every method's estimates. Empty unless the campaign is simulated.
std::vector<Figure> study_truth(const Study& study);
/// Scales as a function of a delay of the reference, with the mean scales of the article, if the campaign names one.
std::vector<Figure> study_timing(const Study& study);
/// Scores of the methods with their intervals, and the four errors that a score combines.
std::vector<Figure> study_ranking(const Study& study);

/// All figures, in that order.
std::vector<Figure> study_figures(const Study& study);

}  // namespace piste
