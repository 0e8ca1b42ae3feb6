#pragma once
/// The result of a study, as values only. study/study.h computes them, study_tables.h and ranking.h summarise them,
/// files/ and report/ show them.
///
/// Here, as in the whole library, an error is what the sensor adds: measured = (1 + scale) true + bias. Tables, files
/// and pictures of a study show corrections to add: true = (1 + scale') measured + bias'. `shown` converts.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/aligned.h"
#include "piste/fit/imu_fit.h"
#include "piste/fit/regression.h"
#include "piste/math/units.h"
#include "piste/study/article.h"
#include "piste/study/signals.h"

namespace piste {

/// The methods to estimate the errors of an IMU, in the order of files and pictures.
enum class Method {
  kNothing,
  kRest,
  kRestAfter,
  kScaleOnly,
  kJoint,
  kJointReverse,
  kJointBothNoisy,
  kBiasOnly,
  kPolynomial,
  kMisalignment,
  kConstantFiltered,
  kConstantSmoothed,
  kWalkFiltered,
  kWalkSmoothed,
  kMarkovFiltered,
  kMarkovSmoothed,
  kConstantAttitudeFiltered,
  kConstantAttitudeSmoothed,
  kWalkAttitudeFiltered,
  kWalkAttitudeSmoothed,
  kMarkovAttitudeFiltered,
  kMarkovAttitudeSmoothed,
  kOtherRuns,
  kInTheFilter,
  kTruth,
};

/// Names and description of a method.
struct MethodInfo {
  Method method;
  std::string_view name;       ///< in files
  std::string_view title;      ///< in pictures
  std::string_view estimates;  ///< "bias", "bias and scale", …; empty if nothing
  std::string_view how;        ///< one sentence
  bool competes;               ///< whether it is ranked; the others are for comparison
};

inline constexpr auto kMethods = std::to_array<MethodInfo>({
    {Method::kNothing, "nothing", "nothing known", "", "The IMU's signals as they came.", false},
    {Method::kRest, "rest", "rest before", "bias", "Mean of the difference at rest before the start.", true},
    {Method::kRestAfter, "rest_after", "rest after", "bias", "Mean of the difference at rest after the stop.", true},
    {Method::kScaleOnly, "scale_only", "run: scale", "bias and scale",
     "Scale in the run, through the mean of the rest; IMU on reference.", true},
    {Method::kJoint, "joint", "run: bias and scale", "bias and scale", "Regression of the reference on the IMU.", true},
    {Method::kJointReverse, "joint_reverse", "run: reverse", "bias and scale",
     "Regression of the IMU on the reference.", true},
    {Method::kJointBothNoisy, "joint_both_noisy", "run: both noisy", "bias and scale",
     "Deming's regression: both signals have noise, in the ratio that the rest shows.", true},
    {Method::kBiasOnly, "bias_only", "run: bias", "bias", "Mean of the difference in the run.", true},
    {Method::kPolynomial, "polynomial", "run: polynomial", "bias and a polynomial scale",
     "A polynomial of the reference's signal, of the order with the smallest BIC.", true},
    {Method::kMisalignment, "misalignment", "run: 3×3", "bias, 3×3 scale and misalignment, g-sensitivity",
     "Each axis of the IMU on all three of the reference, and each gyroscope on the specific force as well.", true},
    {Method::kConstantFiltered, "constant_filtered", "constant, filtered", "bias and scale",
     "Random constants in the GPS/MEMS filter; mean over the run.", true},
    {Method::kConstantSmoothed, "constant_smoothed", "constant, smoothed", "bias and scale",
     "Random constants in the GPS/MEMS filter, smoothed; mean over the run.", true},
    {Method::kWalkFiltered, "random_walk_filtered", "random walk, filtered", "bias and scale",
     "Random walks from a random constant in the GPS/MEMS filter; mean over the run.", true},
    {Method::kWalkSmoothed, "random_walk_smoothed", "random walk, smoothed", "bias and scale",
     "Random walks from a random constant in the GPS/MEMS filter, smoothed; mean over the run.", true},
    {Method::kMarkovFiltered, "gauss_markov_filtered", "Gauss-Markov, filtered", "bias and scale",
     "First-order Gauss-Markov drifts about a random constant in the GPS/MEMS filter; mean over the run.", true},
    {Method::kMarkovSmoothed, "gauss_markov_smoothed", "Gauss-Markov, smoothed", "bias and scale",
     "First-order Gauss-Markov drifts about a random constant in the GPS/MEMS filter, smoothed; mean over the run.",
     true},
    {Method::kConstantAttitudeFiltered, "constant_attitude_filtered", "constant + attitude, filtered", "bias and scale",
     "As constant_filtered, with the attitude of the reference solution as a measurement.", true},
    {Method::kConstantAttitudeSmoothed, "constant_attitude_smoothed", "constant + attitude, smoothed", "bias and scale",
     "As constant_smoothed, with the attitude of the reference solution as a measurement.", true},
    {Method::kWalkAttitudeFiltered, "random_walk_attitude_filtered", "random walk + attitude, filtered",
     "bias and scale", "As random_walk_filtered, with the attitude of the reference solution as a measurement.", true},
    {Method::kWalkAttitudeSmoothed, "random_walk_attitude_smoothed", "random walk + attitude, smoothed",
     "bias and scale", "As random_walk_smoothed, with the attitude of the reference solution as a measurement.", true},
    {Method::kMarkovAttitudeFiltered, "gauss_markov_attitude_filtered", "Gauss-Markov + attitude, filtered",
     "bias and scale", "As gauss_markov_filtered, with the attitude of the reference solution as a measurement.", true},
    {Method::kMarkovAttitudeSmoothed, "gauss_markov_attitude_smoothed", "Gauss-Markov + attitude, smoothed",
     "bias and scale", "As gauss_markov_smoothed, with the attitude of the reference solution as a measurement.", true},
    {Method::kOtherRuns, "other_runs", "scale of the other runs", "bias and scale",
     "Scale of joint_both_noisy in the same IMU's other runs, and the bias that the rest before then has: what could "
     "be known without a reference on that run.",
     true},
    {Method::kInTheFilter, "in_the_filter", "estimated in the replay", "",
     "Nothing is fed: the replay estimates bias, drift and scale itself.", false},
    {Method::kTruth, "truth", "truth", "bias and scale", "What the simulator put in.", false},
});

constexpr const MethodInfo& info(Method method) { return kMethods[static_cast<std::size_t>(method)]; }

/// The estimate of one axis in one run by one method: a bias, or bias and scale, or none.
struct AxisEstimate {
  std::optional<Term> bias_alone;  ///< of a method without scale: bias + scale · mean signal
  std::optional<BiasScale> line;
  /// The true values of the quantities that this method estimates. For a method without scale, bias + scale · mean
  /// signal.
  std::optional<double> true_bias, true_scale;

  bool empty() const { return !bias_alone && !line; }
};

/// The estimates of all axes by one method.
struct MethodEstimate {
  Method method{};
  std::array<AxisEstimate, kSignals> axes;
};

/// Navigation errors, against the reference solution, of a replay that uses the IMU errors of a method.
struct NavigationScore {
  Method method{};
  double position_rmse = 0, velocity_rmse = 0;  ///< of three axes [m], [m/s]
  double attitude_rmse = 0;                     ///< of the angle between the two attitudes [rad]
  double outage_drift = 0;                      ///< rms distance from the reference at the ends of outages [m]
};

/// Scale factors (by both regressions, measured = (1 + scale) true) that a residual timing error causes.
struct TimingEffect {
  double delay = 0;  ///< by which the reference is late [s]
  std::array<double, kSignals> forward{}, reverse{};
};

/// The low-passed signals of both IMUs, for figures 7, 9 and 10.
struct SignalPicture {
  std::vector<double> time;  ///< [s] GPS
  std::array<std::vector<double>, kSignals> measured, reference;
};

/// The name of a run's fused IMU in files and on pages.
inline constexpr std::string_view kAsOne = "all as one";

/// The results for one IMU in one run, or for all IMUs of a run fused into one.
struct SensorRun {
  std::size_t run = 0, sensor = 0;  ///< indices in Study::runs and Study::sensors
  std::vector<std::string> imus;    ///< the IMUs that are fused; empty for a single one
  std::string failure;              ///< why there are no further results; empty if all went well
  std::vector<std::string> warnings;
  double clock_offset = 0, clock_drift = 0;                                   ///< [s], ratio
  Vector3d boresight = Vector3d::Zero(), sigma_boresight = Vector3d::Zero();  ///< roll, pitch, heading of R_rb
  Vector3d lever_arm = Vector3d::Zero();                                      ///< r → b, in r
  std::optional<Findings> findings;
  std::vector<MethodEstimate> estimates;  ///< in the order of kMethods; only methods with an estimate
  std::vector<NavigationScore> scores;    ///< in the order of kMethods; only methods with a score
  std::vector<TimingEffect> timing;
  std::optional<SignalPicture> picture;  ///< only of the first IMU in a run that has one

  /// The estimate of an axis by a method, or null if there is none.
  const AxisEstimate* estimate(Method method, int axis) const;
};

/// One run of the campaign.
struct StudyRun {
  std::string name, activity;
  std::string failure;
  std::vector<std::string> warnings;
  Phases phases;
  Vector3d sigma_attitude = Vector3d::Zero();  ///< of the reference solution: rms of roll, pitch, heading
  double sigma_position = 0;
  std::size_t outages = 0;  ///< number of outages in a replay
};

/// The results of a study.
struct Study {
  std::string name;                  ///< of the campaign
  double low_pass = 0;               ///< [Hz]
  bool simulated = false;            ///< whether the truth is known
  std::vector<std::string> sensors;  ///< in the order in which the runs name them
  std::vector<StudyRun> runs;
  std::vector<SensorRun> results;        ///< run by run, in the order of the campaign
  std::optional<ArticleBeside> article;  ///< the article that the campaign names
  /// The fused IMU of each run that has several IMUs. It is no sensor of the campaign, so neither `results` nor the
  /// statistics of `results` include it: it adds no information to that of the single IMUs.
  std::vector<SensorRun> as_one = {};
};

/// The same campaign as if the fused IMU were its only sensor, to compute its tables.
Study of_all_as_one(const Study& study);

/// Which of the two numbers of an axis.
enum class StudyQuantity { kBias, kScale };

/// Bias or scale as a correction to add, and its true value in the same form: −bias / (1 + scale) in the unit of files
/// (−bias for a method without scale), and −scale / (1 + scale). Nothing if the method does not estimate it. Example: a
/// bias of 0.02 m/s² and a scale of 0.01 are shown as −0.0198 m/s² and −0.0099.
std::optional<Term> shown(const AxisEstimate& estimate, StudyQuantity quantity, int axis);
std::optional<double> shown_truth(const AxisEstimate& estimate, StudyQuantity quantity, int axis);

}  // namespace piste
