#pragma once
/// Many trials on all cores, summed in the order of their seeds.

#include <functional>
#include <string>
#include <string_view>

#include "piste/experiment/trial.h"

namespace piste {

/// The trials of one scenario with its seed and those that follow, as far as they were run. The sums do not depend on
/// how many ran at once, nor on how often they were stopped and gone on with.
class Ensemble {
 public:
  explicit Ensemble(Scenario scenario);

  /// Called after each trial that was added, by one thread at a time.
  using Observer = std::function<void(const Ensemble&)>;

  /// Runs trials until there are `runs` in all, `jobs` at a time. A trial that throws a DataError is counted as
  /// failed; whatever else it or the observer throws stops all of them and is thrown on.
  void run(std::size_t runs, std::size_t jobs, const Observer& observer = {});

  const Consistency& sums() const { return sums_; }
  std::size_t size() const { return sums_.size(); }

  /// What was run so far, to go on with later. `resume` takes it only if the first trial still gives the same bytes,
  /// whatever changed in scenario, sensor files or program, and returns whether it did.
  std::string save() const;
  bool resume(std::string_view bytes);

 private:
  Scenario scenario_;
  Consistency sums_;
  std::uint64_t first_ = 0;  // hash of the first trial's sums
};

}  // namespace piste
