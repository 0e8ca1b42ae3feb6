#pragma once
/// The batch: the whole run as one least-squares problem, solved by Ceres with SuiteSparse.
///
/// Unknown are position, velocity, attitude and all processes at the times where measurements belong, and once for the
/// run the constants: biases, scales, boresight, lever arm, delays. Between two times stand the samples of the IMU,
/// preintegrated on the rotating Earth, jointly with the drifts (model/preintegration.h); the measurements are those of
/// the filter, and so is the prior. The solution is the most likely trajectory (maximum a posteriori) given all of
/// them:
///
///     Σ |W_k (X_k⁻¹ X_{k+1} ⊟ IMU_k)|² + Σ w_i |z_i|² + |x_0 ⊟ start|²
///
/// Fixes may be wrong. Their weights w_i follow graduated non-convexity (Yang, Antonante,
/// Tzoumas and Carlone 2020): a fix beyond its bound counts as the bound does, and so does not pull. The first weights
/// are what the filter did: 1 for a fix that it used, 0 for one that it refused. A fix that it refused may count again.

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "piste/smoother/rts.h"
#include "piste/start/start.h"

namespace piste {

/// A solved batch, from which the estimate and covariance of any epoch of the filter can be taken.
class BatchRun {
 public:
  virtual ~BatchRun() = default;

  virtual const BatchSummary& summary() const = 0;
  /// All epochs of the filter, with sigmas.
  virtual Solution solution(const ProgressCallback& progress = {}) const = 0;
  /// Estimate and whole covariance of some of them. @pre `rows` ascend
  virtual std::vector<SmoothedState> states(const std::vector<std::size_t>& rows) const = 0;
};

/// Solves a filtered run as a batch, as run_batch() does with its options. A function, so that a program without Ceres
/// can replay.
using BatchSolver = std::function<std::unique_ptr<BatchRun>(const Log&, const FilterOptions&, const FoundStart&,
                                                            const FilterRun&, const ProgressCallback&)>;

/// run_batch() for a replay, or for the trials of an ensemble.
BatchSolver batch_solver(const BatchOptions& batch = {}, std::size_t threads = 1);

/// Solves the run that `filtered` is of. It gives the first trajectory, and what it did with each fix. `found` and
/// `options` are those of the filter. `threads` share the work; the result is the same to the byte. Throws DataError if
/// the problem has no solution.
std::unique_ptr<BatchRun> run_batch(const Log& log, const FilterOptions& options, const FoundStart& found,
                                    const FilterRun& filtered, const BatchOptions& batch = {},
                                    const ProgressCallback& progress = {}, std::size_t threads = 1);

}  // namespace piste
