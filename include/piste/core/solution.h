#pragma once
/// What we believe over a run, and how surely: one row an IMU epoch, stored compactly.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "piste/core/estimate.h"
#include "piste/core/log.h"

namespace piste {

/// What became of a measurement: used; rejected, outside the gate; used although outside, as the filter was wrong;
/// left out within the gate, as its receiver jumped before and has not come back; left out as it repeats the fix
/// before.
enum class Outcome { kUsed, kRejected, kReadmitted, kDisputed, kRepeated };
inline constexpr std::array kOutcomes{Outcome::kUsed, Outcome::kRejected, Outcome::kReadmitted, Outcome::kDisputed,
                                      Outcome::kRepeated};

/// As files and pages call it.
std::string_view outcome_name(Outcome outcome);
/// Whether the filter took it.
inline bool was_used(Outcome outcome) { return outcome == Outcome::kUsed || outcome == Outcome::kReadmitted; }

/// One measurement against its prediction. Names the sensor as "gnss[0].position", "attitude[0]", "rest.velocity" …
struct Innovation {
  double time = 0;
  int source = 0;            ///< index into Solution::sources
  int dof = 3;               ///< rows of the measurement
  Vector3d residual, sigma;  ///< measured − predicted, and the root of the diagonal of its covariance; SI
  double nis = 0, gate = 0;  ///< residual' S⁻¹ residual, and the bound that it was held against (0: none)
  Outcome outcome = Outcome::kUsed;
};

/// Ordinary (not invariant) 1-sigma of one epoch. Euler sigmas belong to (roll, pitch, heading).
struct Sigmas {
  Vector3d position, velocity, euler;
  FullError blocks = FullError::Zero();  ///< of the other blocks; boresight as Euler angles of R_rb; 0 = not estimated
  Vector3d gyro_total_bias = Vector3d::Zero(), accel_total_bias = Vector3d::Zero();  ///< of bias + drift
};

/// Sigmas of an estimate from the covariance of its error. No heap.
Sigmas sigmas_of(const Estimate& x, const StateLayout& layout, const Covariance& P);

class Solution {
 public:
  Solution() = default;
  Solution(StateLayout layout, World world);

  std::size_t size() const { return stride_ ? rows_.size() / stride_ : 0; }
  bool empty() const { return rows_.empty(); }
  const StateLayout& layout() const { return layout_; }
  const World& world() const { return world_; }

  double time(std::size_t i) const { return rows_[i * stride_]; }
  Estimate estimate(std::size_t i) const;
  Sigmas sigmas(std::size_t i) const;

  /// Local north-east-down view of one epoch, as files and pictures show it.
  struct Navigation {
    Geodetic position;
    Vector3d velocity, euler;  ///< velocity in local n; (roll, pitch, heading) of R_nb
  };
  Navigation navigation(std::size_t i) const;

  void reserve(std::size_t epochs) { rows_.reserve(epochs * stride_); }
  void resize(std::size_t epochs) { rows_.resize(epochs * stride_); }
  /// Appends, or overwrites row i. Blocks that the layout does not name are kept as constants of the run.
  void append(double time, const Estimate& x, const Sigmas& s);
  void set(std::size_t i, double time, const Estimate& x, const Sigmas& s);

  std::vector<std::string> sources;      ///< names that Innovation::source points to
  std::vector<Innovation> innovations;   ///< in the order of processing
  std::size_t gnss_late = 0;             ///< fixes that came after the filter had passed them
  double attitude_correlation_time = 0;  ///< [s] of the attitude's errors; 0: not known
  Estimate fixed;                        ///< values of the blocks that are not estimated

 private:
  StateLayout layout_;
  World world_;
  std::size_t stride_ = 0;
  std::vector<double> rows_;
};

}  // namespace piste
