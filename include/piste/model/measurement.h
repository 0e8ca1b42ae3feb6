#pragma once
/// A measurement, in the form of a filter: the residual, its covariance, and a Jacobian for each block on which it
/// depends:
///
///     residual = measured − predicted ≈ Σ_b J_b error_b + noise
///
/// `Linearization` holds these. `MeasurementType` says what a new type of measurement must have.

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "piste/core/estimate.h"
#include "piste/core/options.h"
#include "piste/model/rate_regression.h"
#include "piste/model/strapdown.h"

namespace piste {

/// One measurement linearised at an estimate. It has one to three rows; with fewer than three, the other rows of
/// residual, covariance and Jacobians are not used. A block without a term has no influence on the measurement.
struct Linearization {
  struct Term {
    Block block = Block::kPosition;
    Matrix3d jacobian = Matrix3d::Zero();  ///< rows × size of the block, in its upper left corner
    int column = 0;  ///< of a block of more than three: the element that the first column belongs to

    int size() const { return std::min(3, info(block).size - column); }  ///< columns that count
  };

  int rows = 3;
  bool excluded = false;              ///< its sensor is known to be at fault: it is compared, and not used
  Block observes = Block::kPosition;  ///< the block that it mainly measures
  Vector3d residual = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();
  /// M, the derivative of the prediction by the rate, for the errors-in-variables correction: if the rate was measured
  /// as ω + n, the residual contains −M n. On average the rate in the Jacobians has the fraction `observed_noise` of
  /// the noise of the neighbouring samples (MeasurementContext::rate_without_noise).
  Matrix3d by_rate_noise = Matrix3d::Zero();
  double observed_noise = 0;

  void add(Block block, const Matrix3d& jacobian) { terms_[static_cast<std::size_t>(count_++)] = {block, jacobian, 0}; }
  /// The derivative by the first `size` columns, for a block of that size.
  void add(Block block, const Eigen::Matrix<double, 3, kLargestBlock>& jacobian, int size) {
    for (int column = 0; column < size; column += 3) {
      terms_[static_cast<std::size_t>(count_++)] = {block, jacobian.middleCols<3>(column), column};
    }
  }
  /// Adds `factor` times a term to what there is for its block.
  void accumulate(const Term& more, double factor) {
    for (int i = 0; i < count_; ++i) {
      Term& mine = terms_[static_cast<std::size_t>(i)];
      if (mine.block != more.block || mine.column != more.column) continue;
      mine.jacobian += factor * more.jacobian;
      return;
    }
    terms_[static_cast<std::size_t>(count_++)] = {more.block, factor * more.jacobian, more.column};
  }
  /// The derivative by a block of at most three; zero if it has none.
  Matrix3d jacobian(Block block) const {
    Matrix3d sum = Matrix3d::Zero();
    for (int i = 0; i < count_; ++i) {
      if (term(i).block == block) sum += term(i).jacobian;
    }
    return sum;
  }
  /// Turns its three rows: residual, covariance and Jacobians.
  void turn(const Matrix3d& R) {
    residual = (R * residual).eval();
    covariance = (R * covariance * R.transpose()).eval();
    by_rate_noise = (R * by_rate_noise).eval();
    for (int i = 0; i < count_; ++i) {
      Matrix3d& jacobian = terms_[static_cast<std::size_t>(i)].jacobian;
      jacobian = (R * jacobian).eval();
    }
  }
  int count() const { return count_; }
  const Term& term(int i) const { return terms_[static_cast<std::size_t>(i)]; }

 private:
  std::array<Term, 24> terms_;
  int count_ = 0;
};

/// Whether the rows are along the axes of w, as those of a position, a velocity or an attitude with all three rows are.
inline bool along_world(const Linearization& lin) { return lin.rows == 3 && is_navigation(lin.observes); }

/// The Jacobian (3 × layout size) for the blocks that this run estimates. Blocks that it does not estimate are taken as
/// known, and left out; nowhere else is this decided. Rows beyond `rows` are zero.
using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMostStates>;
Jacobian assemble(const StateLayout& layout, const Linearization& lin);

/// Angular rate and specific force of the body at the time of a measurement, in body axes, corrected for the estimated
/// errors of the IMU.
struct BodyMotion {
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();
  Vector3d rate_variance = Vector3d::Zero();  ///< of the white noise in that rate
};

/// Rate and specific force as means over the last tenth of a second, carried on to the time of the estimate, in body
/// axes at that time, as measured (filter/recent_motion.h). Such a mean is the factor of a delay, unless the fix shows
/// all of a vibration: the noise of a single sample would pass for information on the delay.
struct RecentMotion {
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();
  Vector3d force_change = Vector3d::Zero();  ///< how fast R f changes in w, in b [m/s³]
  double force_variance = 0;                 ///< of the remaining white noise in an axis of the force
  double rate_variance = 0;                  ///< and of the rate
};

class RecentSteps;  // src/model/recent_steps.h

/// The delay of a channel of a sensor, and the block that estimates it. `value` is the known delay if this run does not
/// estimate it.
struct FixDelay {
  double value = 0;  ///< s
  std::optional<Block> block = std::nullopt;
  double by_clock_drift = 0;  ///< its derivative by the estimated drift of the IMU's clock [s]
};

/// A fix that belongs to an earlier time than that of the estimate with which it is compared.
struct Lag {
  double time = 0;                            ///< s by which it belongs earlier; negative: later
  std::optional<Block> block = std::nullopt;  ///< the block whose error is an error of `time`
  double variance = 0;                        ///< of that error [s²]
  double by_clock_drift = 0;                  ///< as FixDelay has it

  bool is_uncertain() const { return block || by_clock_drift != 0; }
};

/// A delay less the gain of the IMU's clock: d − c `elapsed`, with c the clock's drift, and `elapsed` the seconds since
/// FilterOptions::clock_from. Where the run does not estimate the drift, the delay is unchanged.
FixDelay with_clock_drift(FixDelay delay, const StateLayout& layout, const Estimate& x, double elapsed);

/// Adds the Jacobians by the delay and by the drift of the clock. `derivative`: of the prediction, by Lag::time.
void add_delay(Linearization& lin, const Lag& lag, const Vector3d& derivative);

/// Adds the second-order term ½ c δ² of an uncertain delay. Its mean goes into the residual, and its variance into the
/// covariance (the Gaussian second-order filter; Jazwinski 1970, section 9.3). `curvature` c: second derivative of the
/// prediction by the delay δ.
void add_curvature(Linearization& lin, const Lag& lag, const Vector3d& curvature);

/// The part of a mean that its white noise does not explain: `mean` times 1 − 3 `variance` / |mean|², or nothing (James
/// and Stein 1961). Otherwise a Jacobian of noise alone would pass for information.
Vector3d beyond_noise(const Vector3d& mean, double variance);

/// The arguments of linearize() in addition to the fix and the estimate.
struct MeasurementContext {
  const FilterOptions& options;
  const StateLayout& layout;
  const Vector3d& earth_rate;
  const Gravity& gravity;  ///< and the local level at the body
  const ImuStep& step;     ///< as measured; the time of the fix is within it
  double into_step = 0;    ///< time of the fix after the start of the step [s]
  Vector3d rate_variance;  ///< of the gyroscopes' white noise, as a mean over one sample
  bool still = false;      ///< the body is at rest
  double elapsed = 0;      ///< s since the drift of the IMU's clock counts
  double moved = 0;        ///< s: the delay by which the fix was given its place among the samples
  RecentMotion recent = {};
  const RecentSteps* steps = nullptr;          ///< for what comes late; null: `recent` stands for them
  double delay_variance = 0;                   ///< of the estimated delay [s²]; 0 if it is known
  Vector3d neighbour_rate = Vector3d::Zero();  ///< mean of the neighbouring samples (model/strapdown.h), as measured
  const RateRegression* rate_regression = nullptr;  ///< of the rate on that of the neighbouring samples; null: none
  /// For a measurement with a kink, such as |v| at zero: the estimate that fixes the sign branch. Null: the estimate of
  /// the linearisation. A solver that iterates would not converge if the branch changed.
  const Estimate* side = nullptr;

  /// The motion at the time of the fix. Rate and force change linearly within a step.
  BodyMotion motion(const Estimate& x) const;
  /// The mean motion before the time of the fix, corrected likewise.
  BodyMotion mean_motion(const Estimate& x) const;
  /// The rate predicted from the neighbouring samples, without the noise in the rate at the time of the fix. A Jacobian
  /// with the same noise would correlate with the residual, and the mean of the product would pass for an effect of
  /// lever arm and scale (errors in variables). The neighbours' rate is an instrumental variable (Fuller 1987, section
  /// 1.4). Zero at rest.
  Vector3d rate_without_noise(const Estimate& x) const;
  /// The fraction of the neighbouring samples' noise in it.
  double observed_noise() const;
  /// The time by which a fix with this `delay` belongs before the estimate.
  Lag lag(const FixDelay& delay) const {
    return {delay.value - moved, delay.block, delay_variance, delay.by_clock_drift};
  }
};

/// One of the quantities that a fix measures, such as the velocity of a receiver.
struct MeasurementChannel {
  std::string_view name;  ///< empty if a fix measures one quantity only
  /// Another channel of the same fix, or −1. If a channel jumps while its partner agrees with the filter, the sensor is
  /// taken to be at fault, and not the filter (filter/fault_detection.h).
  int partner = -1;
  /// Whether several fixes in a row outside the gate inflate the filter's covariance, so that it uses the next one.
  bool readmitted = true;
  /// s after a fix outside the gate in which the channel is excluded: its assumption does not hold. 0: each fix is
  /// tested by itself.
  double hold = 0;
  /// The axes of its innovations' rows, as pages name them. A channel of fewer rows has fewer.
  std::array<std::string_view, 3> axes{"north", "east", "down"};
};

/// The axes of a body.
inline constexpr std::array<std::string_view, 3> kBodyAxes{"x", "y", "z"};

/// Base of every type in measurement_list.h, with defaults that a type may hide by its own. A type must also have
///
///     static constexpr std::string_view kName;                          as files call it, such as "gnss"
///     static constexpr std::array<MeasurementChannel, N> kChannels;
///     static std::optional<Linearization> linearize(const Fix& fix, int sensor, int channel,
///                                                   const MeasurementContext& context, const Estimate& x);
///
/// linearize() returns nothing for a channel that the fix does not have or that the configuration does not use. A type
/// whose fixes depend on several rotations at once takes a last argument `const Estimate* after = nullptr`, see
/// attitude.h.
template <class FixType>
struct MeasurementType {
  using Fix = FixType;  ///< has a `time` [s]

  /// Whether files number the sensors of this type, as in "gnss[0]".
  static constexpr bool kNumbered = false;
  /// Whether an adaptive filter estimates the noise of this type (filter/adaptation.h).
  static constexpr bool kAdapted = true;
  /// Number of sensors of this type in a run. Each has its own fixes and its own place in the list of sources.
  static int sensors(const FilterOptions&) { return 1; }
  /// Whether the filter uses fixes of this type.
  static bool in_use(const FilterOptions&) { return true; }
  /// The fixes of each sensor in a log. Empty if such fixes are not logged.
  static std::span<const std::vector<Fix>> logged(const Log&) { return {}; }
  /// Nothing if fixes come from a log or from a detector. Otherwise the filter makes pseudo-measurements so many
  /// seconds apart wherever there are samples: their measured value is known beforehand.
  static std::optional<double> interval(const FilterOptions&) { return std::nullopt; }
  /// The delay of a channel of a sensor, `elapsed` seconds after the time from which the drift of the IMU's clock
  /// counts.
  static FixDelay delay(const FilterOptions&, const StateLayout&, int /*sensor*/, int /*channel*/, const Estimate&,
                        double /*elapsed*/) {
    return {};
  }
  /// Whether a fix repeats the one before in every digit.
  static bool repeats(const Fix&, const Fix&) { return false; }
};

}  // namespace piste
