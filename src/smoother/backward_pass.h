#pragma once
/// The backward pass of the smoother over the history of a run.

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "filter/errors_in_variables.h"
#include "filter/history.h"
#include "math/square.h"
#include "model/step_operator.h"
#include "piste/math/interruption.h"
#include "piste/smoother/rts.h"
#include "smoother/many_steps.h"
#include "smoother/smoothed_parts.h"

namespace piste {

/// The pass processes one chunk after the other. Within a chunk λ is propagated backwards through every step. So is the
/// transition from each epoch to the next fix, so that Λ is propagated only where it is used. The smoothed error of the
/// other epochs is propagated forwards from the beginning of the chunk: e ← Φ e − Q λ, which is −P λ without P.
class BackwardPass {
 public:
  enum class Want { kNothing, kParts, kWhole };  // of a row; the parts are those from which sigmas are computed

  explicit BackwardPass(const FilterRun& run, bool covariance = true)
      : run_(run),
        layout_(run.history->layout()),
        covariance_(covariance),
        steps_(layout_, run.history->options(), run.history->earth_rate()),
        about_reference_(run.history->about_reference()),
        considered_(run.history->considered()),
        parts_(layout_, considered_) {
    lambda_.setZero(layout_.size());
    Lambda_.setZero(layout_.size(), layout_.size());
    begin_steps();
  }

  /// Goes back to the row `first`, and calls `visit`. `wants(row)` states what is wanted of a row.
  /// `seen(row, time, parts, whole)` is called for these rows, and for those at which a chunk begins, last row first. λ
  /// is then that of the row. `whole` is the filter's state; it is null where parts were enough. `start(state)` is
  /// called likewise for the start. Without covariance, `exact(row, state)` is called where a chunk begins. After it
  /// `between(row, time, x)` is called for all other rows of the chunk, first row first.
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

  /// The smoothed estimate x̂ ⊞ (mean − P λ).
  Estimate estimate(const FilterState& state) const {
    ErrorVector error = state.mean - state.P.lazyProduct(lambda_);
    considered_.hold(error);
    return boxplus(state.x, layout_, error);
  }

  /// The smoothed estimate and its covariance P − P Λ P, at the row of the last seen() or start().
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
    // The parts have the same bits, whether they are computed alone or with the whole.
    s.P = (parts.P.array() != 0).select(parts.P, s.P);
    return s;
  }

  /// Propagates the attitude's error at the epoch j of the last seen() from here on, to correlate it with the errors at
  /// earlier epochs k: E[e_k e_jᵀ] = P_k M_k. M_j = I − Λ_j P_j goes backwards as λ does, but without the residuals (de
  /// Jong and MacKinnon 1988).
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
  /// The same of one number, a · e_j: the column M_j a is propagated. The row before the smoother's reset is meant.
  void trace(const FilterState& state, const Eigen::VectorXd& a) {
    arrive();
    parts_.find_constants(state.P, state.mean, lambda_, Lambda_);
    const Eigen::Index columns = traced_.cols();
    traced_.conservativeResize(layout_.size(), columns + 1);
    traced_.rightCols<1>() = a - Lambda_ * (state.P * a);
  }
  /// E[e e_jᵀ] a_j of the error at the epoch of the last seen() and of each trace(), in the order of the calls.
  Eigen::MatrixXd lagged_numbers(const Covariance& P) const { return P * traced_here(); }

  /// E[θ θ_jᵀ] of the attitude's errors at the epoch of the last seen() and at those of trace(), in the order of the
  /// calls.
  Eigen::Matrix3Xd lagged(const Covariance& P) const {
    const Eigen::Matrix<double, 3, Eigen::Dynamic> rows = at_row_->turn * P.middleRows<3>(kAttitude);
    return rows * traced_here();
  }

 private:
  static constexpr int kAttitude = full_offset(Block::kAttitude), kNavigation = StepOperator::kNavigation;

  // Sets the lanes of (ρ, ν, θ) to unit vectors, and the lane of λ to λ.
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
  // Index of a lane in row k.
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

  // Reads λ, and the transition over the steps since Λ was propagated, from the lanes.
  void look_at_lanes() {
    if (many_.count == 0) return;
    for (int k = 0; k < layout_.size(); ++k) {
      lambda_(k) = lanes_[lambda_at(k)];
      if (!covariance_) continue;
      for (int i = 0; i < kNavigation; ++i) many_.rows[i][k] = lanes_[lane_at(k, i)];
    }
  }

  // Propagates Λ and the traced columns to the place of λ.
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
      if (!considered_.none()) added_.emplace_back(considered_.left_out(c.update, lambda_));
      update_adjoint(lambda_, c.update);
    }
    if (traces()) {
      if (moved) reset_adjoint(traced_, layout_, c.reset);
      update_adjoint(traced_, c.update);
    }
    begin_steps();
  }

  // λ before the errors-in-variables correction.
  void undo(const History::ScoreCorrection& correction) {
    arrive();
    add_score(lambda_, layout_, correction.score);
    begin_steps();
  }

  using Chunk = History::Chunk;
  using Kind = History::Kind;
  struct Wanted {
    std::size_t row;
    bool whole;
  };
  struct Moments {  // of a filter's error; in their own size, as the fixed types have room for the largest layout
    Eigen::MatrixXd P;
    Eigen::VectorXd mean;
  };

  // Lists the wanted rows before `last`.
  template <class Visit>
  void find_wanted(const Chunk& chunk, std::size_t last, const Visit& visit) {
    wanted_.clear();
    for (std::size_t row = chunk.first; row < last; ++row) {
      if (const Want want = visit.wants(row); want != Want::kNothing) wanted_.push_back({row, want == Want::kWhole});
    }
  }

  // Filters a chunk again from its beginning, and stores what the wanted rows need. Where a stretch without fixes ends
  // that has wanted rows, the filter's covariance and mean are stored, too.
  void filter_again(const Chunk& chunk, const FilterState& begin) {
    const History& history = *run_.history;
    kept_.clear();
    states_.clear();
    ends_.clear();
    std::size_t next = 0, row = chunk.first;
    bool wanted = false;  // a row of this stretch is wanted
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
          considered_.update(P, c.update);
          if (c.moved.size() > 0) {
            reset(P, layout_, c.reset);
          } else if (about_reference_) {
            s.mean += considered_.correction(c.update);
          }
          break;
        }
        case Kind::kInflated:
          end_stretch();
          P.diagonal() += history.inflated(chunk, event);
          break;
        case Kind::kMoved:
          if (event.other != 0) end_stretch();  // constants change
          s.mean += history.moved(chunk, event);
          break;
        case Kind::kScore:
          end_stretch();
          if (const auto c = history.score_correction(chunk, event); !c.estimate_moved) s.mean += c.moved;
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

  // Passes a wanted row to `visit`: the one with index `number` in the chunk, which `event` ends.
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

  // Before this stretch the errors of the constants have other covariances.
  void leave_stretch() {
    if (has_constants_) ends_.pop_back();
    has_constants_ = false;
  }

  // Goes from the end of a chunk, where the row end − 1 ends, back to its beginning.
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
        case Kind::kScore:
          undo(history.score_correction(chunk, *event));
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

  // Propagates the smoothed error forwards from the beginning of a chunk.
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
          if (!considered_.none()) take_added(e);
          if (c.moved.size() == 0) break;
          e -= c.moved;
          reset_error(e, layout_, c.reset);
          break;
        }
        case Kind::kScore:
          if (const auto c = history.score_correction(chunk, event); c.estimate_moved) e -= c.moved;
          break;
        case Kind::kInflated:
          take_added(e);
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

  void take_added(ErrorVector& e) {
    e -= added_.back();
    added_.pop_back();
  }

  bool traces() const { return traced_.cols() > 0; }

  const FilterRun& run_;
  const StateLayout& layout_;
  bool covariance_;
  StepOperator steps_;
  bool about_reference_;
  const Considered& considered_;
  PartsSmoother parts_;
  const SmoothedParts* at_row_ = nullptr;
  ErrorVector lambda_, end_lambda_;  // at the current place, and where Λ is
  Covariance Lambda_, work_;         // Λ where the steps in `many_` end
  StepOperator::Lanes lanes_;        // propagated back through these steps
  ManySteps many_;
  Eigen::MatrixXd traced_;  // three columns for each trace(); where Λ is
  // Of one chunk:
  Chunk chunk_;
  Estimate x_;  // at the current row
  std::vector<StepOperator::Factors> factors_;
  std::vector<StepOperator::Pull> pulls_;
  std::vector<Wanted> wanted_;
  std::vector<double> kept_;        // for each of them, as PartsSmoother stores it
  std::vector<Moments> states_;     // of those that are wanted whole
  std::vector<Moments> ends_;       // at the ends of the stretches with wanted rows
  bool has_constants_ = false;      // of the current stretch
  std::vector<ErrorVector> added_;  // inflations times λ, and what considered states do to corrections; last first
};

}  // namespace piste
