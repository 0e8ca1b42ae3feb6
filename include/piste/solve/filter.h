#pragma once
/// The navigation filter: an error-state Kalman filter with feedback, which takes one IMU sample or fix at a time. Use
/// it directly in a program in real time; `run_filter` (run.h) feeds it a whole log.
///
///     fixes → FixQueue ┐
///     IMU samples ─────┴→ Propagation (with SampleNoise) → measurement models → Trust → update → estimate
///                         RestUpdates, RateMending, NoiseScore, admit_error
///
/// The filter is always one IMU sample behind the newest. It waits for the sample after a step because both neighbours
/// give the slope of rate and force within the step. So a step can be split at the time of a fix without extrapolation.

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "piste/core/solution.h"
#include "piste/model/rate_regression.h"
#include "piste/solve/adaptation.h"
#include "piste/solve/fix_queue.h"
#include "piste/solve/history.h"
#include "piste/solve/initial_state.h"
#include "piste/solve/noise_score.h"
#include "piste/solve/propagation.h"
#include "piste/solve/rate_mending.h"
#include "piste/solve/reference.h"
#include "piste/solve/rest_updates.h"
#include "piste/solve/sample_noise.h"
#include "piste/solve/trust.h"

namespace piste {

/// The filter. `Trust` decides which fixes it uses. When it uses a fix from outside its gate, it adds the error that
/// the fix reveals to its covariance. A copy of a filter has its whole state: two copies that get the same input give
/// the same bytes.
class Filter {
 public:
  /// With a `reference` of the same log the filter is linearised about it: estimate() is then the reference, and mean()
  /// how far the best estimate is from it. Throws ConfigError if the options are not valid.
  Filter(const FilterOptions& options, const World& world, const Start& start,
         std::shared_ptr<const Reference> reference = nullptr);

  /// Adds the next IMU sample, and processes the sample before it. Returns true if there was one: time(), estimate()
  /// and covariance() are then those of its end. All fixes up to that time must have been added before. No heap.
  /// Throws DataError if `sample` is not finite or not later than the one before, and then is as it was before; or if
  /// the filter diverges.
  bool add(const ImuSample& sample);
  /// Adds a fix, in any order of time. `sensor` counts from 0 among the sensors of the fix's type: 1 is the second
  /// receiver for a GnssFix. A fix older than time() is left out and counted by late(). A fix of a type that the
  /// options do not use is left out without a count.
  ///
  /// What comes late by a known or estimated delay is compared with the estimate of the time where it belongs, if it is
  /// added before the samples pass that time, which fixes up to time() + look_ahead() allow. If it is added later, as
  /// in real time, it is compared with the next estimate, carried back over the delay (model/gnss.h).
  void add(int sensor, AnyFix fix);
  /// Processes the last sample. Nothing may be added after it. Returns false if there was no sample. Throws as add().
  bool finish();

  /// How far ahead of the samples fixes must be added so that each is used at the time where it belongs [s]: the
  /// longest delay, and a second more if one is estimated. 0 without delays.
  double look_ahead() const { return setup_->look_ahead; }

  double time() const { return state_.time; }
  const Estimate& estimate() const { return state_.x; }
  const Covariance& covariance() const { return state_.P; }
  bool has_reference() const { return reference_.has_value(); }
  /// The best estimate is estimate() ⊞ mean(). Zero without a reference.
  const ErrorVector& mean() const { return state_.mean; }
  const StateLayout& layout() const { return setup_->layout; }
  const World& world() const { return setup_->world; }
  /// Names of the sources, by Innovation::source.
  const std::vector<std::string>& sources() const { return setup_->names; }
  /// The estimate advanced to the newest sample, for a display that cannot wait for the next one. Without covariance.
  Estimate predicted() const;
  /// Innovations since the last call to clear_innovations().
  std::span<const Innovation> innovations() const { return innovations_; }
  void clear_innovations() { innovations_.clear(); }
  /// What it has learned of the noise so far.
  const Adaptation& adaptation() const { return adaptation_; }
  /// Number of fixes that came too late.
  std::size_t late() const { return late_; }

  /// Records everything that the filter does on `tape`, for a smoother; nullptr ends the recording. The filter does not
  /// own the tape.
  void record(Tape* tape) { tape_ = tape; }
  /// The same, on a history that begins here, with the estimates at the ends of epochs unless these are kept elsewhere;
  /// nullptr ends it.
  void record(History* history, bool rows = true) {
    history_ = history;
    if (history_) history_->begin(state_, setup_->layout, has_reference(), rows);
  }
  /// What it is, for a history that ends here.
  const FilterState& state() const { return state_; }
  const FilterOptions& options() const { return setup_->options; }

 private:
  struct Setup {  // what does not change; shared between copies
    FilterOptions options;
    StateLayout layout;
    World world;
    std::array<double, 4> gate{};  // chi-squared bound by number of rows
    MeasurementSources sources;
    std::vector<std::string> names;
    bool delays_change = false;  // one of them is estimated
    double look_ahead = 0;
    double begin = 0;       // time of the start
    double clock_from = 0;  // from when the drift of the IMU's clock counts
  };

  ImuStep step_of(const ImuSample* after) const;
  void process(const ImuSample* after);
  void advance(const ImuStep& step, const StepNoise& noise);
  void follow_reference(double dt);
  void arrive();
  void leave_reference();
  void take_back_noise();
  void take_information(const Vector3d& information, Block scales);
  double elapsed() const { return state_.time - setup_->clock_from; }
  void find_delays();
  double variance_of(const FixDelay& delay) const;
  void measure(const QueuedFix& fix, const ImuStep& step, double into_step, double lag);
  template <class Type>
  void measure(const typename Type::Fix& fix, const QueuedFix& place, const ImuStep& step, double into_step,
               double lag);
  template <class Type>
  Linearization half_way(const typename Type::Fix& fix, int sensor, int channel, const MeasurementContext& context,
                         const Linearization& at_estimate, double learned);
  void apply(int source, double late, const Linearization& lin);
  void correct_by(const Update& update, const Linearization& lin);
  void propagate_by(Transition transition);
  void admit(const Linearization& lin, double lapse);
  bool moves() const;
  /// Whether the body is at rest, as far as the measurements have not contradicted it.
  bool resting() const { return now_->at_rest && !rest_.withdrawn(); }
  [[noreturn]] void fail(const std::string& why) const;

  std::shared_ptr<const Setup> setup_;
  std::optional<Reference::Reader> reference_;  // at the row of the sample that is processed
  Estimate target_;                             // its estimate
  BodyMotion known_;                            // the motion to it
  FilterState state_;
  std::optional<ImuSample> before_, now_;
  FixQueue queue_;
  std::vector<double> delays_;  // of the sources, by the estimate as it is
  SampleNoise sample_noise_;
  Propagation propagation_;
  RateMending mending_;
  NoiseScore noise_score_;
  Adaptation adaptation_;
  RestUpdates rest_;
  Trust trust_;
  Vector3d rate_variance_ = Vector3d::Zero();  // of the gyro's white noise in the sample that is processed
  Vector3d rate_beside_ = Vector3d::Zero();    // of the samples beside it
  RateRegression rate_regression_;             // of the samples before it
  std::vector<Innovation> innovations_;
  std::size_t late_ = 0;
  Tape* tape_ = nullptr;
  History* history_ = nullptr;
};

}  // namespace piste
