#include "piste/solve/rts.h"

#include <stdexcept>
#include <utility>

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
    const Estimate x = boxplus(epoch.x, correction);
    out_.set(row, epoch.time, x, sigmas_of(x, layout_, smoothed_blocks(epoch.P, reset_jacobian(correction))));
  }

  // G (P − P Λ P) Gᵀ, of which only what sigmas are made of is worked out: each block with itself, velocity with
  // attitude, and every bias with its drift.
  const Covariance& smoothed_blocks(const Covariance& P, const ResetJacobian& G) {
    work_.noalias() = Lambda_ * P;
    blocks_ = P;
    const auto subtract = [&](int i, int j, int rows, int columns) {
      blocks_.block(i, j, rows, columns) -= P.middleCols(i, rows).transpose().lazyProduct(work_.middleCols(j, columns));
    };
    const int v = layout_.offset(Block::kVelocity);
    subtract(0, 0, 3, 3);
    subtract(v, v, 6, 6);
    turn<6>(v, G.velocity_attitude);
    for (const Block b : layout_.blocks()) {
      const int o = layout_.offset(b), size = info(b).size;
      if (o > v + 3) subtract(o, o, size, size);
    }
    if (layout_.has(Block::kBoresight)) turn<3>(layout_.offset(Block::kBoresight), G.boresight);
    for (const auto& [bias, drift] :
         {std::pair(Block::kGyroBias, Block::kGyroDrift), std::pair(Block::kAccelBias, Block::kAccelDrift)}) {
      if (!layout_.has(bias) || !layout_.has(drift)) continue;
      subtract(layout_.offset(bias), layout_.offset(drift), 3, 3);
      subtract(layout_.offset(drift), layout_.offset(bias), 3, 3);
    }
    return blocks_;
  }

  template <int N>
  void turn(int o, const Eigen::Matrix<double, N, N>& G) {
    blocks_.block<N, N>(o, o) = (G * blocks_.block<N, N>(o, o) * G.transpose()).eval();
  }

  const StateLayout& layout_;
  Solution& out_;
  ErrorVector lambda_;
  Covariance Lambda_, work_, blocks_;
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
