#pragma once
/// Runs many trials in parallel and sums them in the order of their seeds.

#include <functional>
#include <string>
#include <string_view>

#include "piste/experiment/trial.h"

namespace piste {

/// The trials of one scenario with its seed and the following ones. The sums do not depend on the number of parallel
/// trials, nor on whether the ensemble was stopped and continued. `batch`: as for run_trial().
class Ensemble {
 public:
  explicit Ensemble(Scenario scenario, BatchSolver batch = {});

  /// Called after each trial, by one thread at a time.
  using Observer = std::function<void(const Ensemble&)>;

  /// Runs trials until there are `runs` in all, `jobs` at a time. A trial that throws a DataError is counted as failed.
  /// Any other exception, from a trial or the observer, stops all trials and is thrown again.
  void run(std::size_t runs, std::size_t jobs, const Observer& observer = {});

  const Consistency& sums() const { return sums_; }
  std::size_t size() const { return sums_.size(); }

  /// Saves the trials so far as bytes; `resume` continues from them. It does so only if the first trial still gives the
  /// same bytes, so that no change of scenario, sensor files or program goes unnoticed. Returns whether it did.
  std::string save() const;
  bool resume(std::string_view bytes);

 private:
  Scenario scenario_;
  BatchSolver batch_;
  Consistency sums_;
  std::uint64_t first_ = 0;  // hash of the first trial's sums
};

}  // namespace piste
