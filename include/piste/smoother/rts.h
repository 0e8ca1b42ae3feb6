#pragma once
/// The smoother: the best estimate at every IMU epoch from all measurements of the run, earlier and later ones.
///
/// It is a fixed-interval smoother on the manifold. It computes the Rauch-Tung-Striebel solution in the form of Bryson
/// and Frazier (Bierman 1977). An adjoint λ and its covariance Λ are propagated backwards over all operations of the
/// filter. At every epoch
///
///     x_smoothed = x̂ ⊞ (−P λ)        P_smoothed = P − P Λ P
///
/// No predicted covariance is inverted, an epoch may have any number of updates, and the reset of each correction
/// enters by its transpose. The run's history (history.h) holds the filter's steps and corrections, from which λ and
/// the transition between two epochs follow. Where no covariance is requested, the smoothed error is propagated from
/// epoch to epoch, e ← Φ e − Q λ. It equals −P λ, but does not need P.

#include <cstddef>
#include <functional>
#include <vector>

#include "piste/filter/run.h"
#include "piste/smoother/attitude_lag.h"

namespace piste {

/// An estimate and the covariance of its error, both smoothed.
struct SmoothedState {
  Estimate x;
  Covariance P;
};

/// Called with a row of the solution, and with the filtered and the smoothed state at its epoch. Both have their full
/// covariances; a Solution keeps only the sigmas.
using EpochObserver = std::function<void(std::size_t row, const FilterState& filtered, const SmoothedState& smoothed)>;

/// Smooths a filtered run. @pre `run` has its history.
/// `at_start`: if given, it is set to the smoothed state at the start, before the first step.
/// `lags`: if given, it is set to the covariances of the attitude's errors at some 2000 pairs of epochs of the run.
/// `rows`: if given, it takes the rows of the solution in the end, first row first; the solution then has none.
/// Throws std::logic_error if `run` has no history, Error if a file of its scratch folder cannot be written or read.
Solution smooth_rts(const FilterRun& run, const ProgressCallback& progress = {}, SmoothedState* at_start = nullptr,
                    std::vector<AttitudeLag>* lags = nullptr, const RowTaker& rows = {});

/// The smoothed estimates of a run without their covariances, which are the most expensive part. They are kept where
/// the history is: in memory or in its scratch folder. Throws as smooth_rts().
Reference smoothed_trajectory(const FilterRun& run, const ProgressCallback& progress = {});

/// Smooths only the given rows, and passes them to `observer`, last row first. Rows before the first of them are not
/// processed, unless `at_start` is given. @pre `rows` ascend. Throws as smooth_rts().
void smooth_rows(const FilterRun& run, const std::vector<std::size_t>& rows, const EpochObserver& observer,
                 SmoothedState* at_start = nullptr);

}  // namespace piste
