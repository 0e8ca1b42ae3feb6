#pragma once
/// Statistics over many runs with known truth. They answer two questions: are the sigmas true, and are the errors as
/// small as possible? docs/consistency.md is an introduction.
///
///     NEES = eᵀ P⁻¹ e     mean: the number of states     (Bar-Shalom, Li and Kirubarajan 2001, section 5.4)
///     NIS  = zᵀ S⁻¹ z     mean: the number of rows; white from one innovation to the next
///     RMSE against the posterior Cramér-Rao bound (Tichavsky 1998), which for a given trajectory is the covariance of
///     the same filter and smoother linearised at the truth
///
/// All means are per degree of freedom: 1 if the covariance is true. Runs are added one by one and not kept.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/solution.h"
#include "piste/math/statistics.h"

namespace piste {

/// The error truth − estimate of the estimated blocks at one epoch, the covariance P that the estimate states, and the
/// variances of the bound. Position, velocity and attitude are along the local level at the estimate
/// (level_from_invariant): the velocity is the ordinary difference, the attitude a rotation vector.
struct ErrorSample {
  int epoch = 0;  ///< @pre first ≤ epoch ≤ last of the grid
  ErrorVector error;
  Covariance P;
  ErrorVector bound;
};

/// Phases of a run, by the motion that was simulated.
enum class Phase { kRest, kUnderWay, kRestAfter };
inline constexpr std::array<std::string_view, 3> kPhaseNames{"rest", "under_way", "rest_after"};

/// The epochs at which the errors of all runs of an ensemble are evaluated.
struct EpochGrid {
  double step = 1;          ///< s
  int first = 0, last = 0;  ///< epochs; 0 is the departure
  Interval cruise;          ///< time under way after speeding up and before slowing down [s from the departure]
  double arrival = 0;       ///< [s from the departure]

  double time(int epoch) const { return step * epoch; }
  int size() const { return last - first + 1; }
  /// The phase at a time, or nothing while the body speeds up or slows down.
  std::optional<Phase> phase(double time) const;
  /// The interval of the grid's times in a phase, or nothing if it has none there.
  std::optional<Interval> interval(Phase phase) const;
};

/// One run compared with its truth.
struct ComparedRun {
  std::uint64_t seed = 0;
  StateLayout layout;
  std::vector<ErrorSample> filtered, smoothed;  ///< some epochs of the grid may be missing
  std::vector<std::string> sources;             ///< of the innovations
  std::vector<Innovation> innovations;          ///< time from the departure
};

/// Blocks whose errors are evaluated together.
struct StateGroup {
  std::string name;
  std::vector<int> rows;  ///< of the error vector
};
/// The groups: the whole state, navigation, biases, scales, and every block by itself.
std::vector<StateGroup> state_groups(const StateLayout& layout);

/// Whether a mean over runs is 1. It fails if Student's t of its difference, over the standard error between runs, is
/// significant with Holm's adjustment for all that are judged together. Errors of one run are correlated over hours,
/// runs are independent. A NEES fails also outside the χ² band of that many runs at one epoch: a few runs far off make
/// their own standard error large.
struct MeanTest {
  double p_value = 1;  ///< adjusted; that of Student's t
  bool holds = true;   ///< it is not significant, or the difference is too small to count
};

/// NEES of a group over the epochs of a phase.
struct GroupConsistency {
  double nees = 0;            ///< mean over runs and epochs, per degree of freedom
  double standard_error = 0;  ///< of that mean, between runs
  MeanTest test;              ///< differences that do not count: below 0.05 under way; at rest within 0.8 and 1.25
  double outside = 0;         ///< share of epochs whose mean over the runs is outside its band
  std::array<double, 3> coverage{};  ///< share of errors within 1, 2, 3 sigma: .6827 .9545 .9973 if normal
  double largest = 0;                ///< largest single error, in sigmas
  std::uint64_t largest_seed = 0;    ///< of the run that has it, to be looked at
};

/// RMSE of a block over the epochs of a phase; SI and radians.
struct BlockAccuracy {
  double rmse = 0, bound = 0, claimed = 0;  ///< of the errors; of the bound; of the stated covariance
  double ratio = 0, standard_error = 0;     ///< rmse / bound, and its standard error between runs
};

/// All statistics of the filter or of the smoother.
struct EstimatorConsistency {
  std::array<std::vector<GroupConsistency>, 3> groups;  ///< by phase; in the order of state_groups
  std::array<std::vector<BlockAccuracy>, 3> blocks;     ///< by phase; in the order of the layout
  std::vector<std::vector<double>> nees;                ///< by group, over the grid; NaN where there is no run
  std::vector<std::vector<BlockAccuracy>> accuracy;     ///< by block, over the grid
};

/// Statistics of the innovations of one source over all runs, under way. Those beyond the gate are included.
struct SourceConsistency {
  std::string name;
  int dof = 0;
  double count = 0, rejected = 0;
  double nis = 0;                           ///< mean, per degree of freedom
  double standard_error = 0;                ///< of the mean over runs, between runs
  MeanTest test;                            ///< a difference below 0.02 does not count
  Band band;                                ///< of the mean if all innovations are independent
  std::array<double, 3> autocorrelation{};  ///< of successive normalised innovations, per axis
  double autocorrelation_band = 0;          ///< ±, if they are white

  /// Whether the autocorrelation of every axis is within its band.
  bool white() const;
};

/// Errors of the heading at one time after the departure, over the runs [rad].
struct HeadingFound {
  double time = 0, runs = 0, rmse = 0;
  double largest = 0, largest_sigma = 0,
         largest_ratio = 0;  ///< of |error|, sigma, |error| / sigma; the runs may differ
};

/// A run that could not be replayed, and why.
struct FailedRun {
  std::uint64_t seed = 0;
  std::string what;
};

/// All statistics of an ensemble.
struct ConsistencyReport {
  int runs = 0;  ///< compared runs, without those that failed
  double probability = 0;
  EpochGrid grid;
  StateLayout layout;
  std::vector<StateGroup> groups;
  std::vector<Band> bands;  ///< by group: of the mean over the runs at one epoch, for pictures
  EstimatorConsistency filter, smoother;
  std::vector<SourceConsistency> sources;
  HeadingFound heading;  ///< of the filter
  std::vector<FailedRun> failures;

  /// Groups whose test fails under way, such as "filter accel_scale".
  std::vector<std::string> outside() const;
  /// Whether the tests of all groups of filter and smoother hold under way, and no run failed.
  bool consistent() const;
};

/// One sentence that says whether filter and smoother are consistent, and if not, what is outside its band.
std::string consistency_verdict(const ConsistencyReport& report);

/// Sums over the runs. The order in which runs are added affects the last bits; RangeSums fixes that order.
class Consistency {
 public:
  explicit Consistency(const EpochGrid& grid) : grid_(grid) {}
  const EpochGrid& grid() const { return grid_; }

  void add(const ComparedRun& run);
  void add_failure(FailedRun failure) { failures_.push_back(std::move(failure)); }
  /// Adds the sums of other runs. Throws DataError if these are of other epochs, blocks or sources.
  void append(const Consistency& other);
  /// Runs added, failed ones included.
  std::size_t size() const { return static_cast<std::size_t>(runs_) + failures_.size(); }

  /// The statistics. If no run was compared, it has only the failures.
  ConsistencyReport report(double probability = 0.999) const;

  /// Saves the sums as bytes, and restores them on the same kind of machine, so that an ensemble can continue where it
  /// was stopped. `restore` throws DataError if the bytes are not from `save`.
  std::string save() const;
  static Consistency restore(std::string_view bytes);

 private:
  // Sums of the filter or of the smoother. Tables are stored row by row: the index of (phase, group) is phase · groups
  // + group.
  struct Sums {
    std::vector<double> runs;                     // by epoch
    std::vector<double> nees;                     // by (epoch, group)
    std::vector<double> square, bound, claimed;   // by (epoch, state): of the error, and of both covariances
    std::vector<double> phase_runs;               // by phase
    std::vector<double> mean, mean_square;        // by (phase, group): of the runs' mean NEES per degree of freedom
    std::vector<double> errors, within, largest;  // by (phase, group); `within` with 1, 2, 3 sigma as last index
    std::vector<double> largest_seed;             // likewise; as numbers, which are exact up to 2⁵³
    std::vector<double> ratio, ratio_square;      // by (phase, block): of the runs' mean square over the bound's
  };
  void prepare(const StateLayout& layout, const std::vector<std::string>& sources);
  void allot(const StateLayout& layout, std::vector<std::string> sources);
  void add(Sums& sums, const std::vector<ErrorSample>& samples, std::uint64_t seed) const;
  void add_innovations(const ComparedRun& run);
  void add_heading(const std::vector<ErrorSample>& filtered);
  EstimatorConsistency summarise(const Sums& sums, double probability) const;
  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& visit);

  EpochGrid grid_;
  StateLayout layout_;
  std::vector<StateGroup> groups_;
  double runs_ = 0;
  Sums filter_, smoother_;
  std::vector<std::string> sources_;
  std::vector<double> source_sums_;  // by (source, term)
  std::vector<double> heading_;
  std::vector<FailedRun> failures_;
};

}  // namespace piste
