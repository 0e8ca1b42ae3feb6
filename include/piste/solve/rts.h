#pragma once
/// Fixed-interval smoother on the manifold, at every IMU epoch.
///
/// The Rauch-Tung-Striebel solution in the form of Bryson and Frazier (Bierman 1977): an adjoint λ and its covariance Λ
/// run backwards over what the filter did, and at every epoch
///
///     x_smoothed = x̂ ⊞ (−P λ)        P_smoothed = P − P Λ P
///
/// No predicted covariance is inverted, any number of updates may stand at one epoch, and the reset of each correction
/// enters with its transpose. The filter's steps are not stored: the run is repeated from checkpoints, so that memory
/// is some hundred bytes an epoch and the covariances are those of the filter to the bit.

#include <cstddef>
#include <functional>
#include <vector>

#include "piste/solve/attitude_lag.h"
#include "piste/solve/run.h"

namespace piste {

/// An estimate and the covariance of its error, both smoothed.
struct SmoothedState {
  Estimate x;
  Covariance P;
};

/// Called with a row of the solution: what the filter believed at its epoch, and what the smoother does. Both with
/// their whole covariances, of which a Solution keeps the sigmas only.
using EpochObserver = std::function<void(std::size_t row, const Tape::Epoch& filtered, const SmoothedState& smoothed)>;

/// `run` with checkpoints, of the same log. `at_start`: takes what is said of the start, before the first step. `lags`:
/// takes how the attitude's errors at some 2000 pairs of epochs, spread over the run, go together.
/// Throws std::logic_error without checkpoints.
Solution smooth_rts(const Log& log, const FilterRun& run, const ProgressCallback& progress = {},
                    SmoothedState* at_start = nullptr, std::vector<AttitudeLag>* lags = nullptr);

/// The same at those rows alone, which ascend, last one first. Nothing is kept, and nothing is done for the rows before
/// the first of them unless `at_start` is asked for.
void smooth_rows(const Log& log, const FilterRun& run, const std::vector<std::size_t>& rows,
                 const EpochObserver& observer, SmoothedState* at_start = nullptr);

}  // namespace piste
