#pragma once
/// Error-state Kalman filter, closed loop, one sample at a time.
///
///     fixes → FixQueue ┐
///     IMU samples ─────┴→ Propagation (with SampleNoise) → measurement models → Trust → update → estimate
///                         RestUpdates, RateMending, admit_error
///
/// The filter lags the newest IMU sample by one: the sample after a step gives the slope of rate and force within it,
/// so that a step is split at a fix with the rate centred on the fix and not extrapolated to it.

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "piste/core/solution.h"
#include "piste/solve/fix_queue.h"
#include "piste/solve/initial_state.h"
#include "piste/solve/propagation.h"
#include "piste/solve/rate_mending.h"
#include "piste/solve/rest_updates.h"
#include "piste/solve/sample_noise.h"
#include "piste/solve/trust.h"

namespace piste {

/// Streaming filter. Which fixes it takes is Trust's to say; what a readmitted one shows it to have missed is admitted
/// to its covariance. Copying it takes its whole state with it; two copies fed alike give the same bytes.
class Filter {
 public:
  /// Throws ConfigError where the options cannot be run with.
  Filter(const FilterOptions& options, const World& world, const Start& start);

  /// The next IMU sample, later than the one before. The sample before it is now processed: returns true when that
  /// completed an epoch, which time(), estimate() and covariance() then show. Fixes up to the epoch's end must have
  /// been added. No heap.
  bool add(const ImuSample& sample);
  /// A fix of a sensor, numbered from 0 among those of its type (a GnssFix of receiver 1, an AttitudeFix of reference
  /// 0); in any order. One that is older than time() is counted as late and left out, and so is, uncounted, one of a
  /// type that the options do not use.
  void add(int sensor, AnyFix fix);
  /// Processes the last sample, after which nothing may be added.
  bool finish();

  double time() const { return state_.time; }
  const Estimate& estimate() const { return state_.x; }
  const Covariance& covariance() const { return state_.P; }
  const StateLayout& layout() const { return setup_->layout; }
  const World& world() const { return setup_->world; }
  /// What Innovation::source points to.
  const std::vector<std::string>& sources() const { return setup_->names; }
  /// Estimate carried, without covariance, to the newest sample: for a display that cannot wait one sample.
  Estimate predicted() const;
  /// Innovations since the last call to clear_innovations().
  std::span<const Innovation> innovations() const { return innovations_; }
  void clear_innovations() { innovations_.clear(); }
  std::size_t late() const { return late_; }

  /// Where to record; nullptr to stop. Not owned, and not copied with the filter.
  void record(Tape* tape) { tape_ = tape; }

 private:
  struct Setup {  // what never changes, shared between copies
    FilterOptions options;
    StateLayout layout;
    World world;
    std::array<double, 4> gate{};  // chi-squared bound by number of rows
    MeasurementSources sources;
    std::vector<std::string> names;
  };

  void process(const ImuSample* after);
  void advance(const ImuStep& step, const StepNoise& noise);
  void measure(const QueuedFix& fix, const ImuStep& step, double into_step);
  template <class Type>
  void measure(const typename Type::Fix& fix, int sensor, const ImuStep& step, double into_step);
  template <class Type>
  Linearization half_way(const typename Type::Fix& fix, int sensor, int channel, const MeasurementContext& context,
                         const Linearization& at_estimate);
  void apply(int source, const Linearization& lin);
  void correct_by(const Update& update, const Linearization& lin);
  void propagate_by(const Transition& transition);
  bool moves() const;

  std::shared_ptr<const Setup> setup_;
  FilterState state_;
  std::optional<ImuSample> before_, now_;
  FixQueue queue_;
  SampleNoise sample_noise_;
  Propagation propagation_;
  RateMending mending_;
  RestUpdates rest_;
  Trust trust_;
  Vector3d rate_variance_ = Vector3d::Zero();  // of the gyro's white noise in the sample that is processed
  std::vector<Innovation> innovations_;
  std::size_t late_ = 0;
  Tape* tape_ = nullptr;
};

}  // namespace piste
