#pragma once
/// The navigation filter: an error-state Kalman filter with feedback, which takes one IMU sample or fix at a time. Use
/// it directly in a program in real time; `run_filter` (run.h) feeds it a whole log.
///
///     IMU samples, fixes → Walker ┬ step ─→ predict ───────────────────────────┐
///                                 └ fix ──→ measurement model → test → update → reset → estimate, covariance
///                                                                │ Trust
///                                    RateMending, NoiseScore, Adaptation, admit_error
///
/// The filter is always one IMU sample behind the newest, as the walk is (walker.h).

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "piste/core/solution.h"
#include "piste/solve/adaptation.h"
#include "piste/solve/filter_state.h"
#include "piste/solve/initial_state.h"
#include "piste/solve/noise_score.h"
#include "piste/solve/rate_mending.h"
#include "piste/solve/recent_motion.h"
#include "piste/solve/reference.h"
#include "piste/solve/standing_force.h"
#include "piste/solve/trust.h"
#include "piste/solve/walker.h"

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
  void add(int sensor, const AnyFix& fix);
  /// Processes the last sample. Nothing may be added after it. Returns false if there was no sample. Throws as add().
  bool finish();

  /// How far ahead of the samples fixes must be added so that each is used at the time where it belongs [s]: the
  /// longest delay, and a second more if one is estimated. 0 without delays.
  double look_ahead() const { return walker_.look_ahead(); }

  double time() const { return state_.time; }
  const Estimate& estimate() const { return state_.x; }
  const Covariance& covariance() const { return state_.P; }
  bool has_reference() const { return reference_.has_value(); }
  /// The best estimate is estimate() ⊞ mean(). Zero without a reference.
  const ErrorVector& mean() const { return state_.mean; }
  const StateLayout& layout() const { return walker_.layout(); }
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
  std::size_t late() const { return walker_.late(); }

  /// What it is now.
  const FilterState& state() const { return state_; }
  const FilterOptions& options() const { return walker_.options(); }

 private:
  template <class Recorder>
  friend class FilterWalk;  // src/solve/filter_walk.h: takes the walker's steps and fixes through the functions here

  struct Setup {  // what does not change; shared between copies
    World world;
    std::array<double, 4> gate{};  // chi-squared bound by number of rows
    std::vector<std::string> names;
  };

  // The Kalman filter.
  Transition predict(const ImuStep& step, const StepNoise& noise);
  std::pair<Update, Trust::Ruling> test(int source, double late, const Linearization& lin);
  ErrorVector update(const Update& u);
  ResetJacobian reset(const ErrorVector& correction);

  // About a reference.
  void follow_reference(double dt);
  ErrorVector arrive_at_reference();
  ErrorVector leave_reference();

  ErrorVector admit(const Linearization& lin, double lapse);
  std::optional<Update> take_information(const Vector3d& information, Block scales);
  void find_delays() { walker_.find_delays(state_.time, state_.x); }
  double variance_of(const FixDelay& delay) const;
  double gate(const Linearization& lin) const { return setup_->gate[static_cast<std::size_t>(lin.rows)]; }
  bool resting() const { return walker_.at_rest(); }
  // Where a boresight is estimated, a reference determines the attitude far better than rest does tilt and bias.
  bool stands() const { return resting() && !layout().has(Block::kBoresight); }
  bool moves() const;
  [[noreturn]] void fail(const std::string& where) const;

  std::shared_ptr<const Setup> setup_;
  Walker walker_;
  FilterState state_;
  std::shared_ptr<const UnitScales> units_;  // of several IMUs; null if their scales act along the axes of the body
  Gravity gravity_;  // as a linear function: where the last step began it is within 4e-9 m/s² of normal gravity
  MotionMean motion_;
  StandingForce standing_;
  Trust trust_;
  std::vector<Innovation> innovations_;
  std::optional<Reference::Reader> reference_;  // at the row of the sample that is processed
  Estimate target_;                             // its estimate
  BodyMotion known_;                            // the motion to it
  RateMending mending_;
  NoiseScore noise_score_;
  Adaptation adaptation_;
};

}  // namespace piste
