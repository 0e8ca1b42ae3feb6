#pragma once
/// The numbers of the article (J.-M. Bonnaz, Évaluation du modèle d'erreur de capteurs MEMS-IMU, XYZ 2008), Tables 1 to
/// 6 as printed, and what follows from numbers such as these: from those of the article, or from a study's own.
///
/// Values are corrections to add, true = (1 + scale') measured + bias', in m/s² and °/s; axes are fx fy fz wx wy wz.

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "piste/experiment/study_findings.h"
#include "piste/math/statistics.h"

namespace piste {

/// A printed number: value, standard deviation, and how far rounding may have moved the value; NaN where there is none.
struct Printed {
  double value = 0, std = 0, rounding = 0;
};
using PrintedRow = std::array<Printed, kSignals>;
using PrintedTable = std::vector<PrintedRow>;  ///< sensor by sensor

/// What a campaign came to.
struct CampaignTables {
  PrintedTable rest;                                      ///< Table 1: bias at rest before the start
  PrintedTable joint_bias, joint_scale;                   ///< Tables 3, 4: both in the run
  std::vector<std::array<double, kSignals>> correlation;  ///< Table 5: of these two
  PrintedTable bias_only;                                 ///< Table 6: bias alone in the run
};

namespace article {

using Row = std::array<double, kSignals>;
/// Of one sensor, as printed.
struct Rows {
  Row value, std;
};

inline constexpr std::array<Rows, 3> kTable1{{
    {{0.034, -0.087, -0.021, -0.072, 0.170, 1.000}, {0.020, 0.100, 0.024, 0.076, 0.076, 0.160}},
    {{0.013, -0.003, -0.034, -0.460, -0.740, 0.530}, {0.010, 0.024, 0.016, 0.089, 0.089, 0.110}},
    {{0.060, -0.038, -0.011, 0.150, -0.310, 0.160}, {0.014, 0.082, 0.021, 0.240, 0.240, 0.160}},
}};
/// Of one sensor, which the article does not name; `before` is sensor 1 of Table 1.
inline constexpr Row kTable2Before{0.034, -0.087, -0.021, -0.072, 0.170, 1.000};
inline constexpr Row kTable2After{0.038, -0.097, -0.019, -0.073, 0.171, 0.997};
inline constexpr std::array<Rows, 3> kTable3{{
    {{-0.110, -0.017, -0.130, -0.220, 0.200, 1.300}, {0.035, 0.026, 0.048, 0.049, 0.120, 0.098}},
    {{-0.160, -0.057, -0.190, -0.520, -0.600, 0.530}, {0.052, 0.009, 0.059, 0.031, 0.054, 0.052}},
    {{0.010, 0.005, -0.100, -0.140, -0.350, 0.210}, {0.030, 0.022, 0.037, 0.180, 0.160, 0.110}},
}};
inline constexpr std::array<Rows, 3> kTable4{{
    {{-0.004, -0.039, -0.024, -0.004, -0.010, 0.002}, {0.005, 0.007, 0.006, 0.002, 0.003, 0.001}},
    {{-0.017, -0.038, -0.024, -0.005, -0.003, -0.001}, {0.006, 0.006, 0.008, 0.001, 0.002, 0.001}},
    {{0.008, -0.043, -0.022, -0.003, -0.008, -0.003}, {0.006, 0.007, 0.006, 0.001, 0.002, 0.001}},
}};
inline constexpr std::array<Row, 3> kTable5{{
    {0.96, -0.33, 0.98, 0.29, 0.45, 0.25},
    {-0.96, 0.31, 0.98, 0.32, 0.50, 0.31},
    {0.96, 0.35, 0.98, 0.28, 0.48, 0.31},
}};
inline constexpr std::array<Rows, 3> kTable6{{
    {{-0.078, -0.009, 0.042, -0.226, 0.151, 1.323}, {0.012, 0.030, 0.007, 0.050, 0.116, 0.099}},
    {{-0.047, -0.051, -0.018, -0.530, -0.612, 0.525}, {0.012, 0.005, 0.008, 0.031, 0.049, 0.053}},
    {{-0.041, 0.014, 0.059, -0.142, -0.393, 0.201}, {0.012, 0.025, 0.004, 0.180, 0.150, 0.107}},
}};

}  // namespace article

/// Tables 1 and 3 have two significant digits and at most three decimals, Tables 4 and 6 three decimals.
CampaignTables article_tables();

/// The same of a study: means over the runs, and their spread.
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

/// Numbers of Table 5 whose sign is not that of −mean: sensor and axis.
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

/// What the run adds to the bias at rest, Table 6 − Table 1.
struct Shift {
  std::vector<double> value;     ///< by sensor
  std::vector<double> in_sigma;  ///< its size over the standard deviations of both
  bool same_sign = false;        ///< on all sensors
};
std::array<Shift, kSignals> shifts(const CampaignTables& tables);

/// Correlation of two tables over all sensors and the three axes of a triad.
double table_correlation(const PrintedTable& a, const PrintedTable& b, bool gyro);

/// Ratios of the standard deviations of two tables, by sensor.
std::vector<std::array<double, kSignals>> std_ratios(const PrintedTable& a, const PrintedTable& b);

/// Pairs of axes whose standard deviations are the same on every sensor: a copying error, most likely.
/// @pre at least one sensor
std::vector<std::pair<int, int>> equal_std(const PrintedTable& table);

}  // namespace piste
