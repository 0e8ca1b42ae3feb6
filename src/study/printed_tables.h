#pragma once
/// Conclusions from the tables of a campaign, of an article or of a study.

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "piste/math/statistics.h"
#include "piste/study/article.h"
#include "piste/study/study_findings.h"

namespace piste {

/// The tables of a study in the form of an article: means over the runs and their spread.
CampaignTables campaign_tables(const Study& study);

/// The mean of the measured signal in the run that three tables imply. A least-squares line passes through the mean
/// point, so the bias alone is bias' + scale' · mean.
struct ImpliedMean {
  double value = 0;
  std::optional<Band> bounds;  ///< from the rounding; nothing if the scale may be zero
};
struct ImpliedMeans {
  std::vector<std::array<ImpliedMean, kSignals>> sensors;
  /// The intersection of the bounds of all sensors, because they were on one plate. Nothing if it is empty.
  std::array<std::optional<Band>, kSignals> common;
};
ImpliedMeans implied_means(const CampaignTables& tables);

/// The rms and the spread of the measured signal that its mean and the correlation imply: correlation = −mean / rms.
struct ImpliedSpread {
  double mean = 0, rms = 0, std = 0;
};
ImpliedSpread implied_spread(double mean, double correlation);

/// Sensor and axis of the correlations whose sign is not the sign of −mean.
std::vector<std::pair<std::size_t, int>> wrong_signs(const CampaignTables& tables, const ImpliedMeans& means);

/// How many numbers of a table are significant, by several rules.
struct SignificantCount {
  std::size_t all = 0;
  std::size_t above_one_sigma = 0;  ///< the article's rule: the error bar does not cross zero
  std::size_t at_one_sigma = 0;     ///< value and sigma are printed with the same digits
  std::size_t above_two_sigma = 0;
  double expected_by_chance = 0;  ///< above one sigma, if every true value is zero and errors are normal
  std::size_t holm_of_mean = 0;  ///< Student's t at 5 % after Holm's correction, of a mean over the runs: std / √runs
  std::size_t holm_of_one = 0;   ///< the same with std as the error of the number itself
};
/// Counts over the numbers that have a spread. @pre at least two runs
SignificantCount significant_count(const PrintedTable& table, std::size_t runs);

/// Tests whether the numbers of a table are negative as often as positive.
struct SignTest {
  std::size_t negative = 0, all = 0;
  double p_value = 1;  ///< probability of at least as many negative ones by chance, one-sided
};
SignTest sign_test(const PrintedTable& table);

/// The difference between the bias in the run and the bias at rest.
struct Shift {
  std::vector<double> value;     ///< by sensor
  std::vector<double> in_sigma;  ///< its magnitude in standard deviations of both
  bool same_sign = false;        ///< whether it has the same sign on all sensors
};
std::array<Shift, kSignals> shifts(const CampaignTables& tables);

/// Correlation of two tables over all sensors and the three axes of a triad.
double table_correlation(const PrintedTable& a, const PrintedTable& b, bool gyro);

/// Mean of an axis over the sensors in the table. NaN if there is none.
double axis_mean(const PrintedTable& table, int axis);

/// Ratios of the standard deviations of two tables, by sensor.
std::vector<std::array<double, kSignals>> std_ratios(const PrintedTable& a, const PrintedTable& b);

/// Pairs of axes with equal standard deviations on every sensor that has them: most likely a copying error.
std::vector<std::pair<int, int>> equal_std(const PrintedTable& table);

}  // namespace piste
