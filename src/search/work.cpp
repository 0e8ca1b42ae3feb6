#include "search/work.h"

#include <algorithm>
#include <mutex>
#include <string>
#include <utility>

namespace piste {

struct Work::State {
  StageProgress report;
  std::mutex mutex;
  double left = 0;                // costs from the step at hand on
  double from = 0, to = 0;        // the share of the step at hand
  double cost = 0, reported = 0;  // of the step at hand; the furthest that was reported
  std::string stage;

  // Ends the step at hand. @pre locked
  void end_step() {
    left = std::max(0.0, left - cost);
    from = to;
    cost = 0;
  }
  // @pre locked
  void say(double part) {
    reported = std::max(reported, part);
    report(stage, reported);
  }
};

Work::Work(StageProgress report) {
  if (!report) return;
  state_ = std::make_shared<State>();
  state_->report = std::move(report);
}

void Work::expect(double cost) const {
  if (!state_) return;
  const std::lock_guard lock(state_->mutex);
  state_->end_step();
  state_->left = cost;
}

void Work::expect_more(double cost) const {
  if (!state_) return;
  const std::lock_guard lock(state_->mutex);
  state_->end_step();
  state_->left += cost;
}

ProgressCallback Work::step(std::string_view stage, double cost) const {
  if (!state_) return {};
  State& s = *state_;
  const std::lock_guard lock(s.mutex);
  s.end_step();
  s.left = std::max(s.left, cost);
  s.cost = cost;
  s.stage = stage;
  s.to = s.left > 0 ? s.from + (1 - s.from) * cost / s.left : s.from;
  s.say(s.from);
  return [state = state_, from = s.from, to = s.to](double part) {
    const std::lock_guard locked(state->mutex);
    state->say(from + (to - from) * std::clamp(part, 0.0, 1.0));
  };
}

void Work::finish() const {
  if (!state_) return;
  const std::lock_guard lock(state_->mutex);
  state_->end_step();
  state_->from = state_->to = 1;
  state_->say(1);
}

}  // namespace piste
