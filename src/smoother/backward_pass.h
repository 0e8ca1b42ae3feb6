#pragma once
/// The backward pass of the smoother over a run's history.

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "filter/history.h"
#include "filter/noise_score.h"
#include "math/square.h"
#include "model/step_operator.h"
#include "piste/math/interruption.h"
#include "piste/smoother/rts.h"
#include "smoother/many_steps.h"
#include "smoother/smoothed_parts.h"

namespace piste {

/// It goes chunk by chunk. In a chunk λ goes back through every step, and so does the transition from each epoch to the
/// next fix, so that Λ needs to be carried only where it is used. The smoothed error of the other epochs follows
/// forwards from the chunk's beginning, e ← Φ e − Q λ, which is −P λ without P.
class BackwardPass {
 public:
  enum class Want { kNothing, kParts, kWhole };  // of a row; the parts are those of which sigmas are made

  explicit BackwardPass(const FilterRun& run, bool covariance = true)
      : run_(run),
        layout_(run.history->layout()),
        covariance_(covariance),
        steps_(layout_, run.history->options(), run.history->earth_rate()),
        about_reference_(run.history->about_reference()),
        parts_(layout_) {
    lambda_.setZero(layout_.size());
    Lambda_.setZero(layout_.size(), layout_.size());
    begin_steps();
  }

  /// Goes back to the row `first`. Of `visit`: `wants(row)` says what is wanted of a row.
  /// `seen(row, time, parts, whole)` is called for these rows, and for those at which a chunk begins, the last row
  /// first, when λ is that of the row; `whole`, the filter's state, is null where parts were enough. `start(state)` is
  /// called likewise for the start. Without covariance, `exact(row, state)` is called where a chunk begins, and
  /// `between(row, time, x)` for all other rows of the chunk after that, the first row first.
  template <class Visit>
  void run(std::size_t first, const ProgressCallback& progress, Visit&& visit) {
    const History& history = *run_.history;
    for (std::size_t c = history.size(); c-- > 0;) {
      const std::size_t begin = history.first(c), end = c + 1 < history.size() ? history.first(c + 1) : begin;
      if (end <= first && first > 0) return;
      check_interruption();
      history.load(c, chunk_);
      sweep(chunk_, end, visit);
      if (progress && begin < run_.epochs)
        progress(1 - static_cast<double>(begin) / static_cast<double>(std::max<std::size_t>(1, run_.epochs)));
    }
  }

  /// x̂ ⊞ (mean − P λ).
  Estimate estimate(const FilterState& state) const {
    return boxplus(state.x, layout_, state.mean - state.P.lazyProduct(lambda_));
  }

  /// The same, and P − P Λ P about it, at the row of the last seen() or start().
  SmoothedState smooth(const FilterState& state) {
    const SmoothedParts& parts = *at_row_;
    const Covariance& P = state.P;
    const int n = layout_.size();
    work_.resize(n, n);
    set_product(many_.count > 0 ? carried(many_, Lambda_) : Lambda_, P, work_);
    SmoothedState s{parts.x, Covariance(n, n)};
    set_product(P, work_, s.P);
    s.P = P - s.P;
    reset(s.P, layout_, reset_jacobian(layout_, state.mean - P.lazyProduct(lambda_)));
    // The parts have the same bits, whether they are wanted alone or with the rest.
    s.P = (parts.P.array() != 0).select(parts.P, s.P);
    return s;
  }

  /// Keeps the attitude's error at the epoch j of the last seen(), to correlate it with the errors at earlier epochs
  /// k: E[e_k e_jᵀ] = P_k M_k, where M_j = I − Λ_j P_j goes backwards as λ does, but without the residuals (de Jong and
  /// MacKinnon 1988).
  void trace(const FilterState& state) {
    arrive();
    const Covariance& P = state.P;
    parts_.find_constants(P, state.mean, lambda_, Lambda_);
    const Eigen::Index columns = traced_.cols();
    traced_.conservativeResize(layout_.size(), columns + 3);
    Eigen::Matrix<double, Eigen::Dynamic, 3> M = -Lambda_ * P.middleCols<3>(kAttitude);
    M.middleRows<3>(kAttitude).diagonal().array() += 1;
    traced_.rightCols<3>() = M * at_row_->turn.transpose();
  }
  /// E[θ θ_jᵀ] of the attitude's errors at the epoch of the last seen() and at those of trace(), in the order of
  /// trace().
  Eigen::Matrix3Xd lagged(const Covariance& P) const {
    const Eigen::Matrix<double, 3, Eigen::Dynamic> rows = at_row_->turn * P.middleRows<3>(kAttitude);
    return rows * traced_here();
  }

 private:
  static constexpr int kAttitude = full_offset(Block::kAttitude), kNavigation = StepOperator::kNavigation;

  // Unit vectors in the lanes of (ρ, ν, θ), and λ beside them.
  void begin_steps() {
    const int n = layout_.size();
    many_.count = 0;
    if (covariance_) {
      std::fill(lanes_.begin(), lanes_.begin() + static_cast<std::ptrdiff_t>(lane_at(n, 0)), 0.0);
      for (int k = 0; k < kNavigation; ++k) lanes_[lane_at(k, k)] = 1;
      for (int k = 0; k < n; ++k) many_.decay[k] = k < kNavigation ? 0 : 1;
    }
    for (int k = 0; k < n; ++k) {
      if (!covariance_) std::fill_n(lanes_.begin() + static_cast<std::ptrdiff_t>(lambda_at(k)), kFewLanes, 0.0);
      lanes_[lambda_at(k)] = lambda_(k);
    }
    end_lambda_ = lambda_;
  }
  static constexpr std::size_t kLanes = StepOperator::kLanes, kFewLanes = 4;
  // Where a lane of a row stands.
  static std::size_t lane_at(int k, int lane) {
    return static_cast<std::size_t>(k) * kLanes + static_cast<std::size_t>(lane);
  }
  std::size_t lambda_at(int k) const {
    return covariance_ ? lane_at(k, StepOperator::kLambda) : static_cast<std::size_t>(k) * kFewLanes;
  }

  void step_back(const StepOperator::Factors& f, StepOperator::Pull& pull) {
    ++many_.count;
    if (!covariance_) {
      steps_.adjoint_lambda(f, lanes_, pull);
      return;
    }
    steps_.adjoint(f, lanes_, pull);
    for (int k = kNavigation; k < layout_.size(); ++k) many_.decay[k] *= steps_.decay(f, k);
  }

  // λ, and the transition over the steps since Λ was carried, from the lanes.
  void look_at_lanes() {
    if (many_.count == 0) return;
    for (int k = 0; k < layout_.size(); ++k) {
      lambda_(k) = lanes_[lambda_at(k)];
      if (!covariance_) continue;
      for (int i = 0; i < kNavigation; ++i) many_.rows[i][k] = lanes_[lane_at(k, i)];
    }
  }

  // Carries Λ and what is traced to where λ is.
  void arrive() {
    if (many_.count == 0) return;
    look_at_lanes();
    if (covariance_) {
      Lambda_ = carried(many_, Lambda_);
      if (traces()) traced_ = traced_here();
    }
    begin_steps();
  }
  Eigen::MatrixXd traced_here() const {
    if (many_.count == 0) return traced_;
    Eigen::MatrixXd here(traced_.rows(), traced_.cols());
    apply_transposed(many_, traced_.data(), traced_.rows(), traced_.cols(), here.data());
    return here;
  }

  void undo(const History::Correction& c) {
    arrive();
    const bool moved = c.moved.size() > 0;
    if (covariance_) {
      if (moved) reset_adjoint(lambda_, Lambda_, layout_, c.reset);
      update_adjoint(lambda_, Lambda_, c.update);
    } else {
      if (moved) reset_adjoint(lambda_, layout_, c.reset);
      update_adjoint(lambda_, c.update);
    }
    if (traces()) {
      if (moved) reset_adjoint(traced_, layout_, c.reset);
      update_adjoint(traced_, c.update);
    }
    begin_steps();
  }

  // λ before what noise told the scales was taken back.
  void undo(const History::TakenBack& taken) {
    arrive();
    add_score(lambda_, layout_, taken.score);
    begin_steps();
  }

  using Chunk = History::Chunk;
  using Kind = History::Kind;
  struct Wanted {
    std::size_t row;
    bool whole;
  };
  struct Moments {  // of a filter's error; in their own size, as their types have room for the largest
    Eigen::MatrixXd P;
    Eigen::VectorXd mean;
  };

  // The rows before `last` that are wanted.
  template <class Visit>
  void find_wanted(const Chunk& chunk, std::size_t last, const Visit& visit) {
    wanted_.clear();
    for (std::size_t row = chunk.first; row < last; ++row) {
      if (const Want want = visit.wants(row); want != Want::kNothing) wanted_.push_back({row, want == Want::kWhole});
    }
  }

  // What the wanted rows of a chunk need of the filter, filtered again from its beginning. Where a stretch without
  // fixes ends that has wanted rows, the filter's state is kept, too.
  void filter_again(const Chunk& chunk, const FilterState& begin) {
    const History& history = *run_.history;
    kept_.clear();
    states_.clear();
    ends_.clear();
    std::size_t next = 0, row = chunk.first;
    bool wanted = false;  // in this stretch
    FilterState s = begin;
    Covariance& P = s.P;
    const auto end_stretch = [&] {
      if (wanted) ends_.push_back({s.P, s.mean});
      wanted = false;
    };
    for (const History::Event& event : chunk.events) {
      if (next == wanted_.size() && !wanted) return;
      switch (event.kind) {
        case Kind::kStep: {
          const Transition t = steps_.transition(history.step(chunk, event));
          propagate(P, layout_, t);
          if (about_reference_) propagate(s.mean, layout_, t);
          break;
        }
        case Kind::kCorrection: {
          end_stretch();
          const History::Correction c = history.correction(chunk, event);
          update(P, c.update);
          if (c.moved.size() > 0) {
            reset(P, layout_, c.reset);
          } else if (about_reference_) {
            s.mean += gain(c.update) * c.update.residual;
          }
          break;
        }
        case Kind::kInflated:
          end_stretch();
          P.diagonal() += history.inflated(chunk, event);
          break;
        case Kind::kMoved:
          if (event.other != 0) end_stretch();  // other constants
          s.mean += history.moved(chunk, event);
          break;
        case Kind::kTakenBack:
          end_stretch();
          if (const History::TakenBack t = history.taken_back(chunk, event); !t.estimate_moved) s.mean += t.moved;
          break;
        case Kind::kRow:
          if (next < wanted_.size() && wanted_[next].row == row) {
            parts_.keep(P, s.mean, kept_);
            if (wanted_[next].whole) states_.push_back({P, s.mean});
            wanted = true;
            ++next;
          }
          ++row;
          break;
      }
    }
    end_stretch();
  }

  // Sets x_ to the filter's estimate at a row, and returns its time.
  double look_at_row(const Chunk& chunk, const History::Event& event, std::size_t row) {
    if (run_.history->has_row(event)) return run_.history->row(chunk, event, x_);
    x_ = run_.solution.estimate(row);
    return run_.solution.time(row);
  }

  // The wanted row number `number` of a chunk, which `event` ends.
  template <class Visit>
  void see(const Chunk& chunk, const History::Event& event, const Wanted& wanted, std::size_t number, Visit& visit) {
    if constexpr (requires { visit.seen(number, 0.0, *at_row_, static_cast<const FilterState*>(nullptr)); }) {
      look_at_lanes();
      if (!has_constants_) parts_.find_constants(ends_.back().P, ends_.back().mean, end_lambda_, Lambda_);
      has_constants_ = true;
      const double time = look_at_row(chunk, event, wanted.row);
      at_row_ = &parts_.row(kept_.data() + number * parts_.kept_size(), x_, lanes_.data(), many_.decay, Lambda_);
      if (!wanted.whole) return visit.seen(wanted.row, time, *at_row_, nullptr);
      const FilterState state{time, x_, states_.back().P, states_.back().mean};
      states_.pop_back();
      visit.seen(wanted.row, time, *at_row_, &state);
    }
  }

  // Behind it other constants are known.
  void leave_stretch() {
    if (has_constants_) ends_.pop_back();
    has_constants_ = false;
  }

  // From the end of a chunk, where the row end − 1 ends, to its beginning.
  template <class Visit>
  void sweep(const Chunk& chunk, std::size_t end, Visit& visit) {
    const History& history = *run_.history;
    const std::size_t last = std::max(chunk.first + 1, end) - 1;  // the row that begins the next chunk
    const FilterState begin = history.start(chunk);
    x_ = begin.x;
    find_wanted(chunk, last, visit);
    filter_again(chunk, begin);
    has_constants_ = false;

    const auto steps = static_cast<std::size_t>(std::count_if(
        chunk.events.begin(), chunk.events.end(), [](const History::Event& e) { return e.kind == Kind::kStep; }));
    if (factors_.size() < steps) {
      factors_.resize(steps);
      pulls_.resize(steps);
    }
    std::size_t step = steps, row = end, left = wanted_.size();
    added_.clear();
    for (auto event = chunk.events.rbegin(); event != chunk.events.rend(); ++event) {
      switch (event->kind) {
        case Kind::kStep:
          --step;
          steps_.load(history.step(chunk, *event), factors_[step]);
          step_back(factors_[step], pulls_[step]);
          break;
        case Kind::kCorrection:
          undo(history.correction(chunk, *event));
          leave_stretch();
          break;
        case Kind::kTakenBack:
          undo(history.taken_back(chunk, *event));
          leave_stretch();
          break;
        case Kind::kInflated:
          arrive();
          leave_stretch();
          added_.emplace_back(history.inflated(chunk, *event).cwiseProduct(lambda_));
          break;
        case Kind::kMoved:
          if (event->other == 0) break;
          arrive();
          leave_stretch();
          break;
        case Kind::kRow:
          --row;
          if (left == 0 || wanted_[left - 1].row != row) break;
          --left;
          see(chunk, *event, wanted_[left], left, visit);
          break;
      }
    }
    arrive();
    if (covariance_) {
      leave_stretch();
      parts_.find_constants(begin.P, begin.mean, lambda_, Lambda_);
      kept_.clear();
      parts_.keep(begin.P, begin.mean, kept_);
      at_row_ = &parts_.row(kept_.data(), begin.x, lanes_.data(), many_.decay, Lambda_);
    }
    if (chunk.first == 0) {
      visit.start(begin);
    } else if constexpr (requires { visit.exact(row, begin); }) {
      visit.exact(chunk.first - 1, begin);
    } else {
      visit.seen(chunk.first - 1, begin.time, *at_row_, &begin);
    }
    if constexpr (requires { visit.between(row, 0.0, begin.x); }) {
      if (last > chunk.first) forward(chunk, last, begin, visit);
    }
  }

  // The smoothed error from the beginning of a chunk on.
  template <class Visit>
  void forward(const Chunk& chunk, std::size_t last, const FilterState& begin, Visit& visit) {
    const History& history = *run_.history;
    ErrorVector e = begin.mean - begin.P.lazyProduct(lambda_);
    std::size_t step = 0, row = chunk.first;
    for (const History::Event& event : chunk.events) {
      if (row == last) return;
      switch (event.kind) {
        case Kind::kStep:
          steps_.forward(factors_[step], e, &pulls_[step]);
          ++step;
          break;
        case Kind::kCorrection: {
          const History::Correction c = history.correction(chunk, event);
          if (c.moved.size() == 0) break;
          e -= c.moved;
          reset_error(e, layout_, c.reset);
          break;
        }
        case Kind::kTakenBack:
          if (const History::TakenBack t = history.taken_back(chunk, event); t.estimate_moved) e -= t.moved;
          break;
        case Kind::kInflated:
          e -= added_.back();
          added_.pop_back();
          break;
        case Kind::kMoved:
          e += history.moved(chunk, event);
          break;
        case Kind::kRow: {
          const double time = look_at_row(chunk, event, row);
          visit.between(row, time, boxplus(x_, layout_, e));
          ++row;
          break;
        }
      }
    }
  }

  bool traces() const { return traced_.cols() > 0; }

  const FilterRun& run_;
  const StateLayout& layout_;
  bool covariance_;
  StepOperator steps_;
  bool about_reference_;
  PartsSmoother parts_;
  const SmoothedParts* at_row_ = nullptr;
  ErrorVector lambda_, end_lambda_;  // here, and where Λ is
  Covariance Lambda_, work_;         // Λ where the steps in `many_` end
  StepOperator::Lanes lanes_;        // what has gone back through these steps
  ManySteps many_;
  Eigen::MatrixXd traced_;  // three columns each; where Λ is
  // Of one chunk:
  Chunk chunk_;
  Estimate x_;  // that of the row which is looked at
  std::vector<StepOperator::Factors> factors_;
  std::vector<StepOperator::Pull> pulls_;
  std::vector<Wanted> wanted_;
  std::vector<double> kept_;        // of each of them, as PartsSmoother has it
  std::vector<Moments> states_;     // of those that are wanted whole
  std::vector<Moments> ends_;       // of the stretches with wanted rows
  bool has_constants_ = false;      // of the stretch here
  std::vector<ErrorVector> added_;  // times λ, the last first
};

}  // namespace piste
