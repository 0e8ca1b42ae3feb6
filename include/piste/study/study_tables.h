#pragma once
/// The tables of a study. Values are corrections to add (study_findings.h), in m/s² and °/s; scales are ratios.
///
/// There are three sigmas. The formal one is right if noise is white. The error within a run allows for coloured noise,
/// and for errors of reference and alignment. The spread between runs contains all that changes from run to run, which
/// is most of the uncertainty. A number is significant if its mean over the runs is significant against their spread,
/// by Student's t with Holm's correction over all numbers of a table. The probability of even one false finding is then
/// 5 %.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/study/study_findings.h"

namespace piste {

inline constexpr double kSignificance = 0.05;

/// Statistics of a number over several runs.
struct Across {
  std::size_t runs = 0;
  double mean = 0;
  double std = 0;             ///< between runs; NaN if there is one run
  double standard_error = 0;  ///< of the mean: std / √runs; for one run its total error
  double p_value = 1;  ///< of a mean of zero, by Student's t with runs − 1 degrees of freedom; for one run its own
  double p_holm = 1;   ///< p_value after Holm's correction over its table
  bool significant = false;  ///< p_holm < kSignificance
  double formal = 0;         ///< rms of the formal sigmas of the runs
  double within = 0;         ///< rms of the total errors within the runs
};

/// One axis of one sensor. The rows of a table are ordered by sensor, then fx to wz. An axis without a number has no
/// row.
struct AcrossRow {
  std::size_t sensor = 0;
  int axis = 0;
  Across value;
  double reverse = 0;           ///< for Method::kJoint: the mean of kJointReverse; else NaN
  std::optional<double> truth;  ///< mean of the true values
};

/// The table of one method: Tables 1 (kRest), 3 and 4 (kJoint), 6 (kBiasOnly), and the same for every other method.
std::vector<AcrossRow> table_of(const Study& study, Method method, StudyQuantity quantity);

/// Table 2: bias at rest before and after, over the runs that have both.
struct BeforeAfterRow {
  std::size_t sensor = 0;
  int axis = 0;
  double before = 0, after = 0;
  Across difference;  ///< after − before
};
std::vector<BeforeAfterRow> before_after(const Study& study);

/// Cross-axis errors of one axis of one sensor, by Method::kMisalignment, as corrections to add: ratios.
///
/// The accelerometers define the axes of the body, x along the first, y in the plane of the first two. Their elements
/// are yx, zx and zy, those of the gyroscopes xy, xz, yx, yz, zx and zy. The matrices of a run are about the axes of
/// the estimated boresight. What a small rotation Θ between the two adds to all matrices is taken out:
///
///     Θ_ij = A_ij = −Θ_ji (i < j)      accelerometers M_ji = A_ji + A_ij      gyroscopes M_ij = G_ij − Θ_ij
///
/// with A and G the off-diagonal elements found. So an error of the boresight cancels. Errors of two axes count as
/// independent. Rows are ordered by sensor, axis and element; a sensor without both matrices has none.
struct CrossAxisRow {
  std::size_t sensor = 0;
  int axis = 0;  ///< fx to wz
  std::string_view element;
  Across value;
};
std::vector<CrossAxisRow> cross_axis(const Study& study);

/// How much of the scatter of a scale between runs comes from cross-axis errors: standard deviations between the runs
/// that have both, of Method::kJoint, which knows none, and of Method::kMisalignment. `explained` is 1 less the ratio
/// of their variances, and negative where the second scatters more.
struct ScaleScatter {
  std::size_t sensor = 0;
  int axis = 0;
  std::size_t runs = 0;
  double alone = 0, with_cross_axis = 0, explained = 0;
};
std::vector<ScaleScatter> scale_scatter(const Study& study);

/// Table 5: the formal correlation of bias and scale; it is the same for corrections to add. `correlation` is the mean
/// magnitude over the runs, with the sign of the mean. `lowest` and `highest` are over the runs. `inflation` is the
/// factor 1 / (1 − correlation²) of either variance: 5.3 for a correlation of 0.9. For kJointReverse the correlation is
/// −mean / rms of the reference's signal, so it depends on the motion alone.
struct CorrelationRow {
  std::size_t sensor = 0;
  int axis = 0;
  double correlation = 0, lowest = 0, highest = 0, inflation = 1;
};
std::vector<CorrelationRow> correlations(const Study& study, Method method = Method::kJointReverse);

/// The difference a − b of two methods, over the runs that have both. If b is Method::kTruth, b is the true value of
/// the quantity that a estimates. Sigmas within a run are those of paired estimates (paired_difference).
struct Comparison {
  std::size_t sensor = 0;
  int axis = 0;
  StudyQuantity quantity{};
  Method a{}, b{};
  Across difference;
};
/// The comparisons of all pairs of methods, a before b. Holm's correction is over the sensors and axes of each pair.
std::vector<Comparison> comparisons(const Study& study, StudyQuantity quantity);

/// How often the true value lies inside the stated 95 % interval, over runs, sensors and the three axes of a triad.
struct Coverage {
  Method method{};
  StudyQuantity quantity{};
  bool gyro = false;
  std::size_t inside = 0, all = 0;
  double worst = 0;  ///< largest error over its total sigma
  double rate() const { return static_cast<double>(inside) / static_cast<double>(all); }
};
/// The coverage of all methods. Empty unless the campaign is simulated.
std::vector<Coverage> coverage(const Study& study);

/// How an IMU navigates if the replay estimates its errors itself (Method::kInTheFilter): root mean squares over the
/// runs in which it has a score.
struct ImuCompared {
  std::string name;
  std::size_t runs = 0;
  double position_rmse = 0, velocity_rmse = 0, attitude_rmse = 0;  ///< [m], [m/s], [rad]
  double outage_drift = 0;                                         ///< [m]; NaN if there was no outage
  /// Of the fused IMU: attitude error and drift divided by the mean of the single IMUs in the same runs. Else NaN.
  double attitude_over_single = 0, drift_over_single = 0;
};
/// The IMUs compared with one another, in the order of the study, and last the fused IMU, if it was replayed.
std::vector<ImuCompared> imus_compared(const Study& study);

/// Effect of a timing error: the change of the correction scale' relative to no delay. It is averaged over the sensors
/// of each run, and then over the runs.
struct TimingRow {
  double delay = 0;  ///< s
  std::array<double, kSignals> forward{}, reverse{}, forward_error{},
      reverse_error{};  ///< error: standard, between runs
};
std::vector<TimingRow> timing(const Study& study);

}  // namespace piste
