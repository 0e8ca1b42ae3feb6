#pragma once
/// Error-state Kalman filter, closed loop: one sample at a time, or over a whole log.
///
/// The filter lags the newest IMU sample by one: the sample after a step gives the slope of rate and force within it,
/// so that a step is split at a fix with the rate centred on the fix and not extrapolated to it.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/core/solution.h"
#include "piste/model/attitude.h"
#include "piste/model/dynamics.h"
#include "piste/solve/kalman.h"
#include "piste/solve/trust.h"

namespace piste {

/// Where a filter begins: an estimate, and the covariance of its error. Of the navigation blocks alone (9 × 9, order ρ,
/// ν, θ), where the other blocks begin with the sigmas of the sensor and of the options; or of the whole layout.
struct Start {
  double time = 0;
  Estimate x;
  Covariance covariance = Covariance::Identity(9, 9);
  /// A heading that is known only later, such as when a body that rested begins to move; the filter takes it then.
  std::optional<HeadingFix> heading = std::nullopt;
};

/// Covariance of a start, at the layout's size.
Covariance initial_covariance(const StateLayout& layout, const FilterOptions& options, const Start& start);

/// What the filter did, in order, for a smoother to run backwards. Filled only where a tape is given.
struct Tape {
  struct Propagation {
    Transition transition;
  };
  struct Correction {
    Update update;
    ResetJacobian reset;
  };
  /// End of an IMU epoch: the smoother reports here.
  struct Epoch {
    double time;
    Estimate x;
    Covariance P;
  };
  std::vector<std::variant<Propagation, Correction, Epoch>> events;
};

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
  /// A measurement, in any order; one that is older than time() is counted as late and left out.
  void add(int receiver, const GnssFix& fix);
  void add(int reference, const AttitudeFix& fix);
  void add(const MagneticSample& sample);
  /// Processes the last sample, after which nothing may be added.
  bool finish();

  double time() const { return state_.time; }
  const Estimate& estimate() const { return state_.x; }
  const Covariance& covariance() const { return state_.P; }
  const StateLayout& layout() const { return setup_->layout; }
  const World& world() const { return setup_->world; }
  const std::vector<std::string>& sources() const { return setup_->sources; }
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
    std::vector<std::string> sources;
    int first_attitude = 0, magnetic = 0, start = 0, rest = 0;  // places in sources; a receiver takes two
  };
  struct State {
    double time;
    Estimate x;
    Covariance P;
  };
  struct Pending {
    double time;
    int source;  // index into Setup::sources, the order at equal times
    int index;   // of the receiver or the reference
    std::variant<GnssFix, AttitudeFix, MagneticSample, HeadingFix> fix;
  };

  void enqueue(Pending&& pending);
  void process(const ImuSample* after);
  void advance(const ImuStep& step, const StepNoise& noise);
  void measure(const Pending& pending, const ImuStep& step, double tau);
  void measure_rest(const ImuSample& sample);
  void apply(int source, const Linearization& lin);
  void mend_rate_before(const Linearization& lin);
  void admit_error(const Linearization& lin, double lapse);
  bool moves() const;
  StepNoise noise_of(const ImuSample& sample);
  void stand(double dt);
  void refresh_gravity();

  std::shared_ptr<const Setup> setup_;
  State state_;
  Gravity gravity_;
  std::optional<ImuSample> before_, now_;
  std::vector<Pending> queue_;
  std::vector<Innovation> innovations_;
  Trust trust_;
  std::array<int, 6> clipped_in_a_row_{};
  Vector3d rate_variance_ = Vector3d::Zero();  // of the sample that is processed
  Vector3d rest_turn_ = Vector3d::Zero();
  double rest_time_ = 0;  // since the last zero updates
  Vector3d standing_force_ = Vector3d::Zero();
  double standing_time_ = 0;  // since the rest began
  bool still_ = false;
  Matrix3d gyro_noise_ = Matrix3d::Zero();  // covariance of the angle that it made since `mended_`
  double mended_ = -1e300;                  // time of the last attitude fix
  std::size_t late_ = 0;
  Tape* tape_ = nullptr;
};

/// Copies the filter and its place in the log, so that a stretch can be run again.
struct Checkpoint {
  Filter filter;
  std::size_t imu = 0, imu_end = 0, row = 0;  ///< next sample of the log, end of the samples, next row of the solution
  std::vector<std::size_t> gnss, attitude;
  std::size_t magnetic = 0;
};

/// A filtered run, and what a smoother needs to run it again piece by piece.
struct FilterRun {
  Solution solution;
  std::vector<Checkpoint> checkpoints;
};

/// Epochs between checkpoints: a stretch is run again in cache, and the checkpoints cost some hundred bytes an epoch.
inline constexpr int kCheckpointEvery = 128;

/// Called with the fraction done, now and then; may be empty.
using ProgressCallback = std::function<void(double)>;

/// Feeds the log to a Filter from the start's time on: the same bytes as feeding it sample by sample.
/// `checkpoint_every` epochs (0: none). Throws DataError where the filter's covariance ceases to be one.
FilterRun run_filter(const Log& log, const FilterOptions& options, const Start& start, int checkpoint_every = 0,
                     const ProgressCallback& progress = {}, double end_time = 1e300);

/// Runs a stretch again from a checkpoint, recording it: up to and with the epoch of row `end_row` − 1.
void rerun(const Log& log, const Checkpoint& from, std::size_t end_row, Tape& tape);

}  // namespace piste
