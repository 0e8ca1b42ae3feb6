#pragma once
/// What a campaign taught: several IMUs beside one reference, over several runs. Values only; experiment/study.h fills
/// them, study_tables.h and ranking.h sum them up, files/ and report/ show them.
///
/// Here, as in all of the library, an error is what the sensor adds: measured = (1 + scale) true + bias. Tables, files
/// and pictures of a study show corrections to add: true = (1 + scale') measured + bias'. `shown` goes there.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/aligned.h"
#include "piste/experiment/article.h"
#include "piste/experiment/signals.h"
#include "piste/fit/imu_fit.h"
#include "piste/fit/regression.h"
#include "piste/math/units.h"

namespace piste {

/// A way to estimate the errors of an IMU, in the order of files and pictures.
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

struct MethodInfo {
  Method method;
  std::string_view name;       ///< in files
  std::string_view title;      ///< in pictures
  std::string_view estimates;  ///< "bias", "bias and scale", …; empty where it estimates nothing
  std::string_view how;        ///< one sentence
  bool competes;               ///< is ranked; the others are there to be held against
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

/// What one method says of one axis in one run: nothing, a bias, or bias and scale.
struct AxisEstimate {
  std::optional<Term> bias_alone;  ///< of a method that knows no scale: bias + scale · mean signal
  std::optional<BiasScale> line;
  /// What was put in, as this method could see it; of one that knows no scale, bias + scale · mean signal.
  std::optional<double> true_bias, true_scale;

  bool empty() const { return !bias_alone && !line; }
};

struct MethodEstimate {
  Method method{};
  std::array<AxisEstimate, kSignals> axes;
};

/// How well a replay does whose IMU errors are those of a method, against the reference solution.
struct NavigationScore {
  Method method{};
  double position_rmse = 0, velocity_rmse = 0;  ///< of three axes [m], [m/s]
  double attitude_rmse = 0;                     ///< of the angle of the rotation between both [rad]
  double outage_drift = 0;                      ///< rms distance from the reference at the ends of withheld GNSS [m]
};

/// Scale factors (forward and reverse, measured = (1 + scale) true) that a residual timing error makes.
struct TimingEffect {
  double delay = 0;  ///< [s] by which the reference is late
  std::array<double, kSignals> forward{}, reverse{};
};

/// What figures 7, 9 and 10 show: both IMUs, low-passed.
struct SignalPicture {
  std::vector<double> time;  ///< [s] GPS
  std::array<std::vector<double>, kSignals> measured, reference;
};

/// One IMU in one run.
struct SensorRun {
  std::size_t run = 0, sensor = 0;  ///< of Study::runs and Study::sensors
  std::string failure;              ///< why there is nothing more; empty where all went well
  std::vector<std::string> warnings;
  double clock_offset = 0, clock_drift = 0;                                   ///< [s], ratio
  Vector3d boresight = Vector3d::Zero(), sigma_boresight = Vector3d::Zero();  ///< roll, pitch, heading of R_rb
  Vector3d lever_arm = Vector3d::Zero();                                      ///< r → b, in r
  std::optional<Findings> findings;
  std::vector<MethodEstimate> estimates;  ///< in the order of kMethods; a method that has no answer is absent
  std::vector<NavigationScore> scores;    ///< likewise
  std::vector<TimingEffect> timing;
  std::optional<SignalPicture> picture;  ///< of the first IMU of a run that has one

  /// Null where that method has no answer for that axis.
  const AxisEstimate* estimate(Method method, int axis) const;
};

/// One run of the campaign.
struct StudyRun {
  std::string name, activity;
  std::string failure;
  std::vector<std::string> warnings;
  Phases phases;
  Vector3d sigma_attitude = Vector3d::Zero();  ///< of the reference solution, rms over the run: roll, pitch, heading
  double sigma_position = 0;
  std::size_t outages = 0;  ///< windows of withheld GNSS in a replay
};

struct Study {
  std::string name;                  ///< of the campaign
  double low_pass = 0;               ///< [Hz]
  bool simulated = false;            ///< the truth is known
  std::vector<std::string> sensors;  ///< in the order in which the runs name them
  std::vector<StudyRun> runs;
  std::vector<SensorRun> results;        ///< run by run, in the order of the campaign
  std::optional<ArticleBeside> article;  ///< that the campaign names
};

/// The two numbers of an axis.
enum class Quantity { kBias, kScale };

/// Bias or scale as a correction to add, and the truth likewise: −bias / (1 + scale) in the unit of files, and
/// −scale / (1 + scale); −bias of a method that knows no scale. Nothing where the method does not give it.
std::optional<Term> shown(const AxisEstimate& estimate, Quantity quantity, int axis);
std::optional<double> shown_truth(const AxisEstimate& estimate, Quantity quantity, int axis);

}  // namespace piste
