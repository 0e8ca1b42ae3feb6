#pragma once
/// What follows from the printed tables of a campaign: of those of an article, or of a study's own.

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "piste/experiment/article.h"
#include "piste/experiment/study_findings.h"
#include "piste/math/statistics.h"

namespace piste {

/// The tables of a study, under their names in it: means over the runs, and their spread.
CampaignTables campaign_tables(const Study& study);

/// Means of the measured signal in the run that three tables imply. Least squares on a line pass through the mean
/// point, so the bias alone is bias' + scale' · mean.
struct ImpliedMean {
  double value = 0;
  std::optional<Band> bounds;  ///< with the rounding; none where the scale may be zero
};
struct ImpliedMeans {
  std::vector<std::array<ImpliedMean, kSignals>> sensors;
  /// In the bounds of all sensors, as they shared one plate; none where these contradict one another.
  std::array<std::optional<Band>, kSignals> common;
};
ImpliedMeans implied_means(const CampaignTables& tables);

/// Rms and spread of the measured signal that mean and correlation imply: correlation = −mean / rms.
struct ImpliedSpread {
  double mean = 0, rms = 0, std = 0;
};
ImpliedSpread implied_spread(double mean, double correlation);

/// Correlations whose sign is not that of −mean: sensor and axis.
std::vector<std::pair<std::size_t, int>> wrong_signs(const CampaignTables& tables, const ImpliedMeans& means);

/// How many numbers of a table are significant by several rules.
struct SignificantCount {
  std::size_t all = 0;
  std::size_t above_one_sigma = 0;  ///< the article's rule: the error bar does not cross zero
  std::size_t at_one_sigma = 0;     ///< value and sigma are printed alike
  std::size_t above_two_sigma = 0;
  double expected_by_chance = 0;  ///< above one sigma, were every true value zero and the errors normal
  std::size_t holm_of_mean = 0;  ///< Student's t at 5 % after Holm's correction, of a mean over the runs: std / √runs
  std::size_t holm_of_one = 0;   ///< likewise where std is taken as the error of the number itself
};
/// Of the numbers that have a spread: those of one run have none. @pre at least two runs
SignificantCount significant_count(const PrintedTable& table, std::size_t runs);

/// Are the numbers of a table as often below as above zero?
struct SignTest {
  std::size_t negative = 0, all = 0;
  double p_value = 1;  ///< of at least so many negative ones by chance; one-sided
};
SignTest sign_test(const PrintedTable& table);

/// What the run adds to the bias at rest.
struct Shift {
  std::vector<double> value;     ///< by sensor
  std::vector<double> in_sigma;  ///< its size over the standard deviations of both
  bool same_sign = false;        ///< on all sensors
};
std::array<Shift, kSignals> shifts(const CampaignTables& tables);

/// Correlation of two tables over all sensors and the three axes of a triad.
double table_correlation(const PrintedTable& a, const PrintedTable& b, bool gyro);

/// Mean of an axis over the sensors that the table has; NaN where there are none.
double axis_mean(const PrintedTable& table, int axis);

/// Ratios of the standard deviations of two tables, by sensor.
std::vector<std::array<double, kSignals>> std_ratios(const PrintedTable& a, const PrintedTable& b);

/// Pairs of axes whose standard deviations are the same on every sensor that has them: a copying error, most likely.
std::vector<std::pair<int, int>> equal_std(const PrintedTable& table);

}  // namespace piste
