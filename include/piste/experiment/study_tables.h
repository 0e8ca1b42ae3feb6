#pragma once
/// The tables of a study: over the runs of a sensor, over methods, over sensors. Corrections to add, as everything that
/// a study shows (study_findings.h), in m/s² and °/s; scales are ratios.
///
/// Three sigmas are kept apart. The formal one holds if noise were white; the standard error within a run knows that it
/// lasts, and what is wrong with reference and alignment; the spread between runs knows all that changes from one run
/// to the next, which is most of it. Significance is that of the mean over the runs against their spread, by Student's
/// t, and by Holm's step-down over all the numbers of a table: the probability of even one false finding is 5 %.

#include <cstddef>
#include <optional>
#include <vector>

#include "piste/experiment/study_findings.h"

namespace piste {

inline constexpr double kSignificance = 0.05;

/// Numbers of several runs, and their mean.
struct Across {
  std::size_t runs = 0;
  double mean = 0;
  double std = 0;             ///< between runs; NaN of one run
  double standard_error = 0;  ///< of the mean: std / √runs; of one run, the total within it
  double p_value = 1;        ///< of a mean of zero: Student's t with runs − 1 degrees of freedom; of one run, its own
  double p_holm = 1;         ///< the same after Holm's correction over its table
  bool significant = false;  ///< p_holm < kSignificance
  double formal = 0;         ///< rms of the formal sigmas of the runs
  double within = 0;         ///< rms of the total errors within the runs
};

/// One axis of one sensor. Rows of a table are sensor by sensor, fx to wz; an axis without a number is left out.
struct AcrossRow {
  std::size_t sensor = 0;
  int axis = 0;
  Across value;
  double reverse = 0;           ///< mean of Method::kJointReverse, where the row is of kJoint; else NaN
  std::optional<double> truth;  ///< mean of what was put in
};

/// Tables 1 (kRest), 3 and 4 (kJoint), 6 (kBiasOnly), and the like of every other method.
std::vector<AcrossRow> table_of(const Study& study, Method method, Quantity quantity);

/// Table 2: bias at rest before and after, over the runs that have both.
struct BeforeAfterRow {
  std::size_t sensor = 0;
  int axis = 0;
  double before = 0, after = 0;
  Across difference;  ///< after − before
};
std::vector<BeforeAfterRow> before_after(const Study& study);

/// Table 5: formal correlation of bias and scale, which a correction to add shares: mean magnitude over the runs with
/// the sign of the mean; the lowest and the highest of a run; and the inflation 1 / (1 − correlation²) of either
/// variance. By kJointReverse it is −mean / rms of the reference's signal, and so a matter of the motion alone.
struct CorrelationRow {
  std::size_t sensor = 0;
  int axis = 0;
  double correlation = 0, lowest = 0, highest = 0, inflation = 1;
};
std::vector<CorrelationRow> correlations(const Study& study, Method method = Method::kJointReverse);

/// One estimate against another, or against what was put in as a could see it (Method::kTruth): a − b, over the runs
/// that have both. Sigmas within a run are as if both were independent.
struct Comparison {
  std::size_t sensor = 0;
  int axis = 0;
  Quantity quantity{};
  Method a{}, b{};
  Across difference;
};
/// Every pair of methods, a before b. Holm's correction is within each pair, over sensors and axes.
std::vector<Comparison> comparisons(const Study& study, Quantity quantity);

/// How often what was put in lies inside the stated 95 % interval, over runs, sensors and the three axes of a triad.
struct Coverage {
  Method method{};
  Quantity quantity{};
  bool gyro = false;
  std::size_t inside = 0, all = 0;
  double worst = 0;  ///< largest error over its total sigma
  double rate() const { return static_cast<double>(inside) / static_cast<double>(all); }
};
/// Empty unless the campaign is simulated.
std::vector<Coverage> coverage(const Study& study);

/// Timing errors: change of the correction scale' against no delay, mean over the runs of that over the sensors.
struct TimingRow {
  double delay = 0;  ///< s
  std::array<double, kSignals> forward{}, reverse{}, forward_error{},
      reverse_error{};  ///< error: standard, between runs
};
std::vector<TimingRow> timing(const Study& study);

}  // namespace piste
