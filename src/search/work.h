#pragma once
/// How far work is that is made of steps, some of which turn out to be needed only on the way.

#include <memory>
#include <string_view>

#include "piste/filter/run.h"
#include "piste/search/inspect.h"

namespace piste {

/// Reports the progress of steps whose costs are known roughly beforehand, in any unit. Each step gets the share of
/// what is left that its cost has in the costs that are left, so that the progress never goes back, whatever turns out
/// to be needed besides. A copy is of the same work.
class Work {
 public:
  /// Reports to nobody.
  Work() = default;
  explicit Work(StageProgress report);

  /// The costs of all steps from here on, instead of what was left of the costs before.
  void expect(double cost) const;
  /// Costs of steps that are needed besides.
  void expect_more(double cost) const;
  /// Begins the next step, which ends the one before. The result takes the part of the step that is done, from any
  /// thread, and may be empty.
  ProgressCallback step(std::string_view stage, double cost) const;
  /// All is done.
  void finish() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace piste
