#pragma once
/// Runs many trials in parallel and sums them in the order of their seeds.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "piste/consistency/range_sums.h"
#include "piste/trial/trial.h"

namespace piste {

/// The trials of one scenario: trial i has the scenario's seed plus i. The sums depend neither on the number of
/// parallel trials, nor on whether the ensemble was stopped and continued, nor on its division into parts. `batch`: as
/// for run_trial().
class Ensemble {
 public:
  /// `first`: the number of the first trial, if this is a later part of an ensemble.
  explicit Ensemble(Scenario scenario, BatchSolver batch = {}, std::size_t first = 0);

  /// Called after each trial, by one thread at a time.
  using Observer = std::function<void(const Ensemble&)>;

  /// Runs trials until there are `runs` in all, `jobs` at a time. A trial that throws a DataError is counted as failed.
  /// Any other exception, from a trial or the observer, stops all trials and is thrown again.
  void run(std::size_t runs, std::size_t jobs, const Observer& observer = {});

  Consistency sums() const { return sums_.total(); }
  std::size_t first() const { return sums_.first(); }
  std::size_t size() const { return sums_.size(); }

  /// Saves the trials so far as bytes; `resume` continues from them. It does so only if the bytes begin with the same
  /// trial, and this trial, run again, still gives the same bytes. So no change of scenario, sensor files or program
  /// goes unnoticed. Returns whether it continued.
  std::string save() const;
  bool resume(std::string_view bytes);

  /// Adds the following trials from the bytes that another part saved, without running them again. Throws DataError if
  /// they are of another scenario file or version, or do not follow.
  void append(std::string_view bytes);

 private:
  /// What `save` wrote.
  struct Saved {
    std::uint64_t scenario, first_trial;  // hashes
    RangeSums sums;
  };
  static Saved read(std::string_view bytes);
  std::uint64_t scenario_hash() const;

  Scenario scenario_;
  BatchSolver batch_;
  RangeSums sums_;
  std::uint64_t first_trial_ = 0;  // hash of the first trial's sums
};

}  // namespace piste
