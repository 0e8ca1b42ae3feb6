#include "piste/solve/rts.h"

#include <stdexcept>

namespace piste {
namespace {

// Backward pass over one tape: λ and Λ stand after its last event on entry, before its first on return.
class Backward {
 public:
  Backward(const StateLayout& layout, Solution& out, const EpochObserver& observer)
      : layout_(layout), out_(out), observer_(observer) {
    lambda_.setZero(layout.size());
    Lambda_.setZero(layout.size(), layout.size());
  }

  void run(const Tape& tape, std::size_t end_row) {
    std::size_t row = end_row;
    for (auto event = tape.events.rbegin(); event != tape.events.rend(); ++event) {
      if (const auto* step = std::get_if<Tape::Propagation>(&*event)) {
        propagate_adjoint(lambda_, Lambda_, layout_, step->transition);
      } else if (const auto* correction = std::get_if<Tape::Correction>(&*event)) {
        reset_adjoint(lambda_, Lambda_, layout_, correction->reset);
        update_adjoint(lambda_, Lambda_, correction->update);
      } else if (const auto* epoch = std::get_if<Tape::Epoch>(&*event)) {
        const SmoothedState s = smooth(epoch->x, epoch->P);
        out_.set(--row, epoch->time, s.x, sigmas_of(s.x, layout_, s.P));
        if (observer_) observer_(row, *epoch, s);
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
  Solution& out_;
  const EpochObserver& observer_;
  ErrorVector lambda_;
  Covariance Lambda_, work_;
};

}  // namespace

Solution smooth_rts(const Log& log, const FilterRun& run, const ProgressCallback& progress, SmoothedState* at_start,
                    const EpochObserver& observer) {
  const Solution& filtered = run.solution;
  if (run.checkpoints.empty()) throw std::logic_error("smooth_rts needs a run with checkpoints");
  Solution out(filtered.layout(), filtered.world());
  out.sources = filtered.sources;
  out.fixed = filtered.fixed;
  out.resize(filtered.size());
  Backward backward(filtered.layout(), out, observer);
  std::size_t end_row = filtered.size();
  Tape tape;
  for (auto from = run.checkpoints.rbegin(); from != run.checkpoints.rend(); ++from) {
    tape.events.clear();
    rerun(log, *from, end_row, tape);
    backward.run(tape, end_row);
    end_row = from->row;
    if (progress) progress(1 - static_cast<double>(end_row) / static_cast<double>(filtered.size()));
  }
  const Filter& first = run.checkpoints.front().filter;
  if (at_start) *at_start = backward.smooth(first.estimate(), first.covariance());
  return out;
}

}  // namespace piste
