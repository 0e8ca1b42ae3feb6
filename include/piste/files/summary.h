#pragma once
/// The file `summary.json` of a replay.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "piste/consistency/verdict.h"
#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// Run times of the replay [s].
struct RunTimes {
  double cpu = 0, wall = 0;
};

/// Means over all rows of a solution. The rows may come in pieces.
class RowMeans {
 public:
  void add(const Solution& rows);
  std::size_t count() const { return count_; }
  /// Mean of the total bias and of its sigma, and the rms of the sigmas of roll, pitch and heading. SI and radians.
  Vector3d total_bias(bool gyro) const { return mean(total_[gyro ? 0 : 1]); }
  Vector3d total_bias_sigma(bool gyro) const { return mean(total_sigma_[gyro ? 0 : 1]); }
  Vector3d euler_sigma() const { return mean(euler_variance_).cwiseSqrt(); }

 private:
  Vector3d mean(const Vector3d& sum) const { return sum / (count_ > 0 ? static_cast<double>(count_) : 1.0); }
  std::size_t count_ = 0;
  std::array<Vector3d, 2> total_{Vector3d::Zero(), Vector3d::Zero()}, total_sigma_ = total_;  // gyroscopes first
  Vector3d euler_variance_ = Vector3d::Zero();
};

/// `summary.json`. Its members mean:
///  - `estimates`: the values at the last epoch of `smoothed`, or of `filtered` if there is none. `gyro_total_bias`
///   and `accel_total_bias` are bias + drift averaged over the epochs of the run: the mean of the values, and the mean
///   of the sigmas.
///  - `attitude_error`: the rms over the epochs of the sigmas of roll, pitch and heading, and the correlation time of
///   their errors. It is null if it is unknown, as without a smoother.
///  - `used` and `rejected`: numbers of fixes. A fix of which any part was rejected counts as rejected. `sources`
///   counts each part.
///  - `verdict`: consistency/verdict.h. Of each source `nis`, `rejected` (a share), and further members if they are
///   known; `nis` is null if there were too few fixes. `jumps` of the constants with the largest deviations from their
///   priors, in prior sigmas.
///
///  - `gps_week`: of the run's times, if it is known.
///
/// Everything except `cpu_s` and `wall_s` is the same at every replay.
///
/// `means`: over all rows, if `filtered` has only a part of them; null: `filtered` has all rows. `warnings`: of the
/// run, as terminal and page have them.
std::string summary_json(const Log& log, const Solution& filtered, const Solution* smoothed, const Verdict& verdict,
                         const RunTimes& times, const RowMeans* means = nullptr, std::optional<int> week = {},
                         const std::vector<std::string>& warnings = {});

}  // namespace piste
