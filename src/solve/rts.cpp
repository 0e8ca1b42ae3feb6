#include "piste/solve/rts.h"

#include <stdexcept>

namespace piste {
namespace {

// Backward pass over one tape: λ and Λ stand after its last event on entry, before its first on return.
class Backward {
 public:
  explicit Backward(const StateLayout& layout) : layout_(layout) {
    lambda_.setZero(layout.size());
    Lambda_.setZero(layout.size(), layout.size());
  }

  /// `at_epoch(row, epoch)` is called where λ and Λ stand at the end of that row.
  template <class AtEpoch>
  void run(const Tape& tape, std::size_t end_row, AtEpoch&& at_epoch) {
    std::size_t row = end_row;
    for (auto event = tape.events.rbegin(); event != tape.events.rend(); ++event) {
      if (const auto* step = std::get_if<Tape::Propagation>(&*event)) {
        propagate_adjoint(lambda_, Lambda_, layout_, step->transition);
      } else if (const auto* correction = std::get_if<Tape::Correction>(&*event)) {
        reset_adjoint(lambda_, Lambda_, layout_, correction->reset);
        update_adjoint(lambda_, Lambda_, correction->update);
      } else if (const auto* epoch = std::get_if<Tape::Epoch>(&*event)) {
        at_epoch(--row, *epoch);
      }
    }
  }

  /// x̂ ⊞ (−P λ) and P − P Λ P, about the corrected estimate.
  SmoothedState smooth(const Estimate& x, const Covariance& P) {
    const FullError correction = expand(layout_, -(P.lazyProduct(lambda_)));
    work_.noalias() = Lambda_ * P;
    SmoothedState s{boxplus(x, correction), P};
    s.P.noalias() -= P * work_;
    reset(s.P, layout_, reset_jacobian(correction));
    return s;
  }

 private:
  const StateLayout& layout_;
  ErrorVector lambda_;
  Covariance Lambda_, work_;
};

// Runs the stretches of a filtered run again, last one first, and each of them backwards.
template <class AtEpoch>
void run_backwards(Backward& backward, const Log& log, const FilterRun& run, const ProgressCallback& progress,
                   AtEpoch&& at_epoch) {
  if (run.checkpoints.empty()) throw std::logic_error("a smoother needs a run with checkpoints");
  const std::size_t rows = run.solution.size();
  std::size_t end_row = rows;
  Tape tape;
  for (auto from = run.checkpoints.rbegin(); from != run.checkpoints.rend(); ++from) {
    tape.events.clear();
    rerun(log, *from, end_row, tape);
    backward.run(tape, end_row, at_epoch);
    end_row = from->row;
    if (progress) progress(1 - static_cast<double>(end_row) / static_cast<double>(rows));
  }
}

}  // namespace

Solution smooth_rts(const Log& log, const FilterRun& run, const ProgressCallback& progress, SmoothedState* at_start) {
  const Solution& filtered = run.solution;
  Solution out(filtered.layout(), filtered.world());
  out.sources = filtered.sources;
  out.fixed = filtered.fixed;
  out.resize(filtered.size());
  Backward backward(filtered.layout());
  run_backwards(backward, log, run, progress, [&](std::size_t row, const Tape::Epoch& epoch) {
    const SmoothedState s = backward.smooth(epoch.x, epoch.P);
    out.set(row, epoch.time, s.x, sigmas_of(s.x, out.layout(), s.P));
  });
  const Filter& first = run.checkpoints.front().filter;
  if (at_start) *at_start = backward.smooth(first.estimate(), first.covariance());
  return out;
}

void smooth_rows(const Log& log, const FilterRun& run, const std::function<bool(std::size_t)>& wanted,
                 const EpochObserver& observer) {
  Backward backward(run.solution.layout());
  run_backwards(backward, log, run, {}, [&](std::size_t row, const Tape::Epoch& epoch) {
    if (wanted(row)) observer(row, epoch, backward.smooth(epoch.x, epoch.P));
  });
}

}  // namespace piste
