#include "piste/solve/rts.h"

#include <stdexcept>

namespace piste {
namespace {

// Backward pass over one tape: λ and Λ stand after its last event on entry, before its first on return.
class Backward {
 public:
  Backward(const StateLayout& layout, Solution& out) : layout_(layout), out_(out) {
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
        report(--row, *epoch);
      }
    }
  }

 private:
  void report(std::size_t row, const Tape::Epoch& epoch) {
    const FullError correction = expand(layout_, -(epoch.P.lazyProduct(lambda_)));
    work_.noalias() = Lambda_ * epoch.P;
    Covariance P = epoch.P;
    P.noalias() -= epoch.P * work_;
    reset(P, layout_, reset_jacobian(correction));
    const Estimate x = boxplus(epoch.x, correction);
    out_.set(row, epoch.time, x, sigmas_of(x, layout_, P));
  }

  const StateLayout& layout_;
  Solution& out_;
  ErrorVector lambda_;
  Covariance Lambda_, work_;
};

}  // namespace

Solution smooth_rts(const Log& log, const FilterRun& run, const ProgressCallback& progress) {
  const Solution& filtered = run.solution;
  if (run.checkpoints.empty()) throw std::logic_error("smooth_rts needs a run with checkpoints");
  Solution out(filtered.layout(), filtered.world());
  out.sources = filtered.sources;
  out.fixed = filtered.fixed;
  out.resize(filtered.size());
  Backward backward(filtered.layout(), out);
  std::size_t end_row = filtered.size();
  Tape tape;
  for (auto from = run.checkpoints.rbegin(); from != run.checkpoints.rend(); ++from) {
    tape.events.clear();
    rerun(log, *from, end_row, tape);
    backward.run(tape, end_row);
    end_row = from->row;
    if (progress) progress(1 - static_cast<double>(end_row) / static_cast<double>(filtered.size()));
  }
  return out;
}

}  // namespace piste
