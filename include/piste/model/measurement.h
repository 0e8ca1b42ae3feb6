#pragma once
/// A measurement against its prediction: residual = measured − predicted ≈ Σ J_b error_b + noise; and what a type of
/// measurement must say of itself.

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "piste/core/estimate.h"
#include "piste/core/options.h"
#include "piste/model/strapdown.h"

namespace piste {

/// Three rows at most. Blocks that are not listed have no influence. `rows` may be fewer than three: the rest of
/// residual, covariance and Jacobians is then unused.
struct Linearization {
  struct Term {
    Block block = Block::kPosition;
    Matrix3d jacobian = Matrix3d::Zero();  ///< rows × size of the block, in its upper left corner
  };

  int rows = 3;
  Block observes = Block::kPosition;  ///< what it measures above all
  Vector3d residual = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();

  void add(Block block, const Matrix3d& jacobian) { terms_[static_cast<std::size_t>(count_++)] = {block, jacobian}; }
  int count() const { return count_; }
  const Term& term(int i) const { return terms_[static_cast<std::size_t>(i)]; }

 private:
  std::array<Term, 12> terms_;
  int count_ = 0;
};

/// Jacobian rows (3 × layout size) for the blocks that this run estimates; the others are held as known. The only
/// place that knows. Rows beyond `rows` are zero.
using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kFullSize>;
Jacobian assemble(const StateLayout& layout, const Linearization& lin);

/// Rate and specific force of the body at the instant of a measurement, corrected, body axes.
struct BodyMotion {
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();
  Vector3d rate_variance = Vector3d::Zero();  ///< of the gyro's white noise in that rate
};

/// What a model of a measurement may look at, beside the fix and the estimate.
struct MeasurementContext {
  const FilterOptions& options;
  const StateLayout& layout;
  const Vector3d& earth_rate;
  const Gravity& gravity;
  const ImuStep& step;     ///< as measured; the fix lies within it,
  double into_step = 0;    ///< so many seconds after its start
  Vector3d rate_variance;  ///< of the gyro's white noise over one sample
  bool still = false;      ///< the body is at rest

  /// At the instant of the fix: rate and force are lines within a step.
  BodyMotion motion(const Estimate& x) const;
};

/// One of the quantities that a fix measures, such as the velocity of a receiver.
struct MeasurementChannel {
  std::string_view name;  ///< empty where the fix is one quantity
  /// Another channel of the same fix that errs together with this one, or −1. What leaps against the filter while its
  /// partner agrees is held to be the sensor's fault (solve/trust.h).
  int partner = -1;
  /// Whether the filter is held to be wrong, and takes such fixes, once enough in a row lay outside the gate.
  bool readmitted = true;
};

/// What every sensor type of measurement_list.h says of itself; a type overrides what is different. It must also have
///
///     static constexpr std::string_view kName;                          as files call it, such as "gnss"
///     static constexpr std::array<MeasurementChannel, N> kChannels;
///     static std::optional<Linearization> linearize(const Fix& fix, int sensor, int channel,
///                                                   const MeasurementContext& context, const Estimate& x);
///
/// where linearize() returns nothing of a channel that the fix, or the configuration, leaves out. A type whose fixes
/// tell several rotations at once takes a last argument `const Estimate* after = nullptr`, see attitude.h.
template <class FixType>
struct MeasurementType {
  using Fix = FixType;  ///< has a `time` [s]

  /// Whether files number the sensors of this type, as in "gnss[0]".
  static constexpr bool kNumbered = false;
  /// Of a run; each has its own fixes and its own place in the list of sources.
  static int sensors(const FilterOptions&) { return 1; }
  /// Whether the filter takes such fixes at all.
  static bool in_use(const FilterOptions&) { return true; }
  /// The fixes of each sensor in a log; none of what is not logged.
  static std::span<const std::vector<Fix>> logged(const Log&) { return {}; }
  /// Whether a fix is the one before once more, in every digit.
  static bool repeats(const Fix&, const Fix&) { return false; }
};

}  // namespace piste
