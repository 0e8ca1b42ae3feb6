#pragma once
/// The Kalman filter that `Filter` holds in place. Its equations are in filter.cpp.
///
///     IMU samples, fixes → Walker ┬ step ─→ predict ───────────────────────────┐
///                                 └ fix ──→ measurement model → test → update → reset → estimate, covariance
///                                                                │ FaultDetection
///                                    RateMending, ErrorsInVariables, Adaptation, inflate_covariance
///
/// The filter is always one IMU sample behind the newest, as the walk is (walker.h).

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "filter/adaptation.h"
#include "filter/considered.h"
#include "filter/errors_in_variables.h"
#include "filter/fault_detection.h"
#include "filter/rate_mending.h"
#include "filter/recent_motion.h"
#include "filter/reference.h"
#include "filter/standing_force.h"
#include "model/recent_steps.h"
#include "piste/core/solution.h"
#include "piste/filter/filter_state.h"
#include "piste/filter/initial_state.h"
#include "walker/walker.h"

namespace piste {

/// `Filter` (piste/filter/filter.h) documents the functions. `FaultDetection` decides which fixes are used. When it
/// uses a fix outside the gate, the covariance is inflated by the error that the fix shows.
class KalmanFilter {
 public:
  /// With a `reference` of the same log the filter is linearised about it. estimate() is then the reference, and mean()
  /// the estimate of its error. Throws ConfigError if the options are not valid.
  KalmanFilter(const FilterOptions& options, const World& world, const Start& start,
               std::shared_ptr<const Reference> reference = nullptr);

  bool add(const ImuSample& sample);
  void add(int sensor, const AnyFix& fix);
  bool finish();
  double look_ahead() const { return walker_.look_ahead(); }
  double time() const { return state_.time; }
  const Estimate& estimate() const { return state_.x; }
  const Covariance& covariance() const { return state_.P; }
  const FilterState& state() const { return state_; }
  const StateLayout& layout() const { return walker_.layout(); }
  const World& world() const { return setup_->world; }
  const FilterOptions& options() const { return walker_.options(); }
  const std::vector<std::string>& sources() const { return setup_->names; }
  Estimate predicted() const;
  std::span<const Innovation> innovations() const { return innovations_; }
  void clear_innovations() { innovations_.clear(); }
  std::size_t late() const { return walker_.late(); }
  /// Leaves out the errors-in-variables correction, for a run of which only the innovations count. In an hour it moves
  /// the scales by some of their sigmas, and costs a third of the filter where a vehicle is constrained ten times a
  /// second.
  void leave_scales_uncorrected() { errors_in_variables_ = {}; }

  bool has_reference() const { return reference_.has_value(); }
  /// The best estimate is estimate() ⊞ mean(). Zero without a reference.
  const ErrorVector& mean() const { return state_.mean; }
  /// The estimated factors of the noise.
  const Adaptation& adaptation() const { return adaptation_; }

 private:
  template <class Recorder>
  friend class FilterWalk;  // src/filter/filter_walk.h: passes the walker's steps and fixes to the functions here

  struct Setup {  // constant over the run; shared between copies
    World world;
    std::array<double, 4> gate{};  // chi-squared bound by number of rows
    std::vector<std::string> names;
  };

  // The Kalman filter.
  Transition predict(const ImuStep& step, const StepNoise& noise);
  std::pair<Update, FaultDetection::Ruling> test(int source, double late, const Linearization& lin);
  ErrorVector update(const Update& u);
  ResetJacobian reset(const ErrorVector& correction, const std::optional<Standing>& standing);

  // About a reference.
  void follow_reference(double dt);
  ErrorVector arrive_at_reference();
  ErrorVector leave_reference();

  ErrorVector inflate(const Linearization& lin, double lapse);
  std::optional<ErrorVector> change_slow_error(int receiver, const Vector3d& change);
  std::optional<Update> remove_information(const Vector3d& information, Block scales);
  void find_delays() { walker_.find_delays(state_.time, state_.x); }
  double variance_of(const FixDelay& delay) const;
  double gate(const Linearization& lin) const { return setup_->gate[static_cast<std::size_t>(lin.rows)]; }
  bool resting() const { return walker_.at_rest(); }
  std::optional<Standing> standing() const;
  bool moves() const;
  [[noreturn]] void fail(const std::string& where) const;

  std::shared_ptr<const Setup> setup_;
  Walker walker_;
  FilterState state_;
  Considered considered_;
  std::shared_ptr<const ImuScales> imu_scales_;  // of several IMUs; null if their scales act along the axes of the body
  std::optional<Eigen::Quaterniond> stood_;      // the attitude after the last correction at this rest
  Gravity gravity_;  // as a linear function: at the start of the last step it is within 4e-9 m/s² of normal gravity
  MotionMean motion_;
  RecentSteps steps_;
  StandingForce standing_;
  FaultDetection fault_detection_;
  std::vector<Innovation> innovations_;
  std::optional<Reference::Reader> reference_;  // at the row of the current sample
  Estimate target_;                             // its estimate
  BodyMotion known_;                            // the motion to that estimate
  RateMending mending_;
  ErrorsInVariables errors_in_variables_;
  Adaptation adaptation_;
};

}  // namespace piste
