#pragma once
/// The result of a filter or a smoother: an estimate with its sigmas for each IMU epoch, and all innovations.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/estimate.h"
#include "piste/core/log.h"

namespace piste {

/// The outcome of a measurement in the filter.
enum class Outcome {
  kUsed,
  kRejected,    ///< rejected by the innovation test: outside the gate
  kReadmitted,  ///< used although outside the gate: the filter was at fault, its covariance is inflated
  kDisputed,    ///< excluded although within the gate: its receiver jumped, or runs away, and has not returned
  kRepeated     ///< left out: the receiver repeated its last fix
};
inline constexpr std::array kOutcomes{Outcome::kUsed, Outcome::kRejected, Outcome::kReadmitted, Outcome::kDisputed,
                                      Outcome::kRepeated};

/// Its name in files and pages.
std::string_view outcome_name(Outcome outcome);
/// Whether the filter used the measurement.
inline bool was_used(Outcome outcome) { return outcome == Outcome::kUsed || outcome == Outcome::kReadmitted; }

/// One measurement compared with its prediction. `source` leads to a name such as "gnss[0].position", "attitude[0]" or
/// "rest.velocity".
struct Innovation {
  double time = 0;
  int source = 0;            ///< index into Solution::sources
  int dof = 3;               ///< rows of the measurement
  Vector3d residual, sigma;  ///< measured − predicted, and its 1-sigma; SI; north, east, down where it has these
  double nis = 0, gate = 0;  ///< zᵀ S⁻¹ z of the residual z, and its largest allowed value (0: none)
  Outcome outcome = Outcome::kUsed;
  double late = 0;             ///< time of the fix, as its source states it, less `time` [s]: its delay
  double log_determinant = 0;  ///< ln det S

  /// Whether a row was measured and compared. The others of `residual` and `sigma` say nothing.
  bool has(int row) const { return row < dof && outcome != Outcome::kRepeated; }
};

/// Position, velocity and attitude in the local level n at the position, as files and pictures show them.
struct Navigation {
  Geodetic position;
  Vector3d velocity, euler;  ///< along north, east, down; (roll, pitch, heading) of R_nb
};

/// The navigation part of an estimate in `world`. No heap.
Navigation navigation_of(const World& world, const Estimate& x);

/// 1-sigma of one epoch, of the ordinary (not the invariant) errors. As in Navigation, `position` and `velocity` are
/// along north, east, down at the position, and `euler` is of roll, pitch and heading there.
struct NavigationSigmas {
  Vector3d position, velocity, euler;
};

/// The same of every block.
struct Sigmas : NavigationSigmas {
  FullError blocks = FullError::Zero();  ///< other blocks; boresight: Euler angles of R_rb; 0: not estimated
  Vector3d gyro_total_bias = Vector3d::Zero(), accel_total_bias = Vector3d::Zero();  ///< of bias + drift
};

/// Sigmas of an estimate in `world` from the covariance of its error. No heap.
Sigmas sigmas_of(const World& world, const Estimate& x, const StateLayout& layout, const Covariance& P);

/// The noise that an adaptive filter estimated, one row per second (filter/adaptation.h).
struct AdaptedNoise {
  std::vector<std::string> names;  ///< sources, "gyro_noise" and "accel_noise"; empty: the filter did not adapt
  std::vector<double> time;
  std::vector<double> factors;  ///< of the stated sigmas, row by row

  double factor(std::size_t row, std::size_t name) const { return factors[row * names.size() + name]; }
  /// The factors of one name over all rows: geometric mean, least, most, and the last.
  struct Range {
    double mean = 1, least = 1, most = 1, last = 1;
  };
  Range range(std::size_t name) const;
};

/// Statistics of a batch that smoothed a run (batch/batch.h).
struct BatchSummary {
  std::size_t nodes = 0, fixes = 0;
  std::size_t left_out = 0;    ///< fixes with weight 0
  std::size_t taken_back = 0;  ///< fixes that the filter rejected and the batch uses
  int rounds = 0;              ///< linearisations of the whole run
  int iterations = 0;          ///< steps of all solves
  double cost = 0;             ///< half the sum of squares
  bool converged = false;
};

/// Where a part of an estimate or its sigma stands in the rows of a solution.
struct StoredColumn {
  std::string name;          ///< such as `v_wb`, `sigma_euler`, `gyro_bias`; of a quaternion the order is x, y, z, w
  std::size_t offset, size;  ///< of its values in a row
};

/// Estimates and sigmas of a run, stored compactly, one row for each epoch.
class Solution {
 public:
  Solution() = default;
  Solution(StateLayout layout, World world);

  std::size_t size() const { return stride_ ? rows_.size() / stride_ : 0; }
  bool empty() const { return rows_.empty(); }
  const StateLayout& layout() const { return layout_; }
  const World& world() const { return world_; }

  /// All rows as they are stored, `stride()` values each, for those who share the memory. SI and radians, `v_wb` and
  /// `p_wb` along w, sigmas as in Sigmas.
  std::span<const double> rows() const { return rows_; }
  std::size_t stride() const { return stride_; }
  std::vector<StoredColumn> columns() const;

  double time(std::size_t i) const { return rows_[i * stride_]; }
  Estimate estimate(std::size_t i) const;
  Sigmas sigmas(std::size_t i) const;

  /// Parts of these, without the cost of gathering the blocks.
  Vector3d position(std::size_t i) const;  ///< p_wb
  Navigation navigation(std::size_t i) const;
  NavigationSigmas navigation_sigmas(std::size_t i) const;

  void reserve(std::size_t epochs) { rows_.reserve(epochs * stride_); }
  void resize(std::size_t epochs) { rows_.resize(epochs * stride_); }
  /// Appends a row, or overwrites row i. Blocks that the layout does not have are not stored: `fixed` has their values.
  void append(double time, const Estimate& x, const Sigmas& s);
  void set(std::size_t i, double time, const Estimate& x, const Sigmas& s);
  /// Appends rows as rows() has them. @pre They are of the same layout.
  void append(std::span<const double> rows) { rows_.insert(rows_.end(), rows.begin(), rows.end()); }
  /// Row i as it is stored.
  std::span<const double> row(std::size_t i) const { return rows().subspan(i * stride_, stride_); }

  std::vector<std::string> sources;      ///< names, by Innovation::source
  std::vector<Innovation> innovations;   ///< in the order in which they were processed
  AdaptedNoise adapted;                  ///< the noise that the filter estimated
  std::optional<BatchSummary> batch;     ///< if a batch computed it
  std::size_t gnss_late = 0;             ///< fixes that came too late for the filter
  double attitude_correlation_time = 0;  ///< of the attitude's errors [s]; 0: not known
  Estimate fixed;                        ///< values of the blocks that are not estimated

 private:
  StateLayout layout_;
  World world_;
  std::size_t stride_ = 0;
  std::vector<double> rows_;
};

}  // namespace piste
