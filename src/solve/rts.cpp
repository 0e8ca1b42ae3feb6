#include "piste/solve/rts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "math/wide.h"
#include "piste/solve/noise_score.h"

namespace piste {
namespace {

// A part of a matrix.
struct Part {
  int row, column, rows, columns;
};

using Four = double __attribute__((vector_size(4 * sizeof(double))));

// 4 R rows and C columns of A B, from `row` and `column` on, for matrices of n rows; the first of them from `keep` on
// go to `out`, up to row `end`.
template <int R, int C>
[[gnu::always_inline]] inline void tile_of_product(const double* A, const double* B, int row, int column,
                                                   std::ptrdiff_t n, int keep, int end, double* out) {
  Four sum[C][R] = {};
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    const double* a = A + k * n + row;
    for (int i = 0; i < R; ++i) {
      Four four;
      std::memcpy(&four, a + std::ptrdiff_t{4} * i, sizeof four);
      for (int j = 0; j < C; ++j) sum[j][i] += four * B[(column + j) * n + k];
    }
  }
  for (int j = 0; j < C; ++j) {
    double tile[4 * R];
    std::memcpy(tile, sum[j], sizeof tile);
    for (int i = keep; i < end; ++i) out[(column + j) * n + i] = tile[i - row];
  }
}

// @pre n ≥ 4
template <int C>
[[gnu::always_inline]] inline void columns_of_product(const double* A, const double* B, int column, std::ptrdiff_t n,
                                                      int row, int end, double* out) {
  for (; row + 8 <= end; row += 8) tile_of_product<2, C>(A, B, row, column, n, row, row + 8, out);
  for (; row < end; row += 4) {
    tile_of_product<1, C>(A, B, std::min(row, static_cast<int>(n) - 4), column, n, row, std::min(end, row + 4), out);
  }
}

// `part` of `out` becomes that of A B, all of them with n rows and columns. An element has the same bits in every part.
PISTE_WIDE void multiply(const double* A, const double* B, std::ptrdiff_t n, const Part& part, double* out) {
  const int end = part.row + part.rows, last = part.column + part.columns;
  int column = part.column;
  for (; column + 3 <= last; column += 3) columns_of_product<3>(A, B, column, n, part.row, end, out);
  for (; column < last; ++column) columns_of_product<1>(A, B, column, n, part.row, end, out);
}

void multiply(const Covariance& A, const Covariance& B, const Part& part, Covariance& out) {
  multiply(A.data(), B.data(), A.rows(), part, out.data());
}

// The backward pass. run() takes λ and Λ from after the last event of a tape to before its first.
class Backward {
 public:
  explicit Backward(const StateLayout& layout, bool covariance = true)
      : layout_(layout), covariance_(covariance), for_sigmas_(parts_for_sigmas(layout)) {
    lambda_.setZero(layout.size());
    Lambda_.setZero(layout.size(), layout.size());
  }

  /// `at_epoch(row, epoch)` is called when λ and Λ are those at the end of that row.
  template <class AtEpoch>
  void run(const Tape& tape, std::size_t end_row, AtEpoch&& at_epoch) {
    std::size_t row = end_row;
    for (auto event = tape.events.rbegin(); event != tape.events.rend(); ++event) {
      if (const auto* step = std::get_if<Tape::Propagation>(&*event)) {
        if (covariance_) {
          propagate_adjoint(lambda_, Lambda_, layout_, step->transition);
        } else {
          propagate_adjoint(lambda_, layout_, step->transition);
        }
        if (traces()) propagate_adjoint(traced_, layout_, step->transition);
      } else if (const auto* correction = std::get_if<Tape::Correction>(&*event)) {
        if (covariance_) {
          reset_adjoint(lambda_, Lambda_, layout_, correction->reset);
          update_adjoint(lambda_, Lambda_, correction->update);
        } else {
          reset_adjoint(lambda_, layout_, correction->reset);
          update_adjoint(lambda_, correction->update);
        }
        if (!traces()) continue;
        reset_adjoint(traced_, layout_, correction->reset);
        update_adjoint(traced_, correction->update);
      } else if (const auto* taken = std::get_if<Tape::TakenBack>(&*event)) {
        add_score(lambda_, layout_, taken->score);
      } else if (const auto* end = std::get_if<Tape::EpochEnd>(&*event)) {
        at_epoch(--row, tape.epochs[end->index]);
      }
    }
  }

  /// x̂ ⊞ (mean − P λ).
  Estimate estimate(const Estimate& x, const ErrorVector& mean, const Covariance& P) const {
    return boxplus(x, correction(mean, P));
  }

  /// The same, and P − P Λ P about it. Only where Λ is carried along.
  SmoothedState smooth(const Estimate& x, const ErrorVector& mean, const Covariance& P) {
    return smooth(x, mean, P, std::array{Part{0, 0, layout_.size(), layout_.size()}});
  }
  /// The same with those covariances alone of which sigmas are made, and zeros beside: of navigation, of each block
  /// with itself, and of biases with their drifts.
  SmoothedState smooth_for_sigmas(const Estimate& x, const ErrorVector& mean, const Covariance& P) {
    return smooth(x, mean, P, for_sigmas_);
  }

  /// Keeps the attitude's error at the epoch j of the last smooth(), to correlate it with the errors at earlier epochs
  /// k: E[e_k e_jᵀ] = P_k M_k, where M_j = I − Λ_j P_j goes backwards as λ does, but without the residuals (de Jong and
  /// MacKinnon 1988).
  void trace(const Covariance& P) {
    const Eigen::Index columns = traced_.cols();
    traced_.conservativeResize(layout_.size(), columns + 3);
    Eigen::Matrix<double, Eigen::Dynamic, 3> M = -Lambda_ * P.middleCols<3>(kAttitude);
    M.middleRows<3>(kAttitude).diagonal().array() += 1;
    traced_.rightCols<3>() = M * turn_.transpose();
  }
  /// E[θ θ_jᵀ] of the attitude's errors at the epoch of the last smooth() and at those of trace(), in the order of
  /// trace().
  Eigen::Matrix3Xd lagged(const Covariance& P) const { return turn_ * P.middleRows<3>(kAttitude) * traced_; }

 private:
  static constexpr int kAttitude = full_offset(Block::kAttitude);
  static constexpr int kNavigation = 9;

  static std::vector<Part> parts_for_sigmas(const StateLayout& layout) {
    std::vector<Part> parts{{0, 0, kNavigation, kNavigation}};
    const auto add = [&](Block a, Block b) {
      if (layout.has(a) && layout.has(b))
        parts.push_back({layout.offset(a), layout.offset(b), info(a).size, info(b).size});
    };
    for (const Block b : layout.blocks()) {
      if (!is_navigation(b)) add(b, b);
    }
    for (const auto& [bias, drift] :
         {std::pair{Block::kGyroBias, Block::kGyroDrift}, {Block::kAccelBias, Block::kAccelDrift}}) {
      add(bias, drift);
      add(drift, bias);
    }
    return parts;
  }

  SmoothedState smooth(const Estimate& x, const ErrorVector& mean, const Covariance& P, std::span<const Part> parts) {
    const FullError correction = this->correction(mean, P);
    const int n = layout_.size();
    work_.resize(n, n);
    multiply(Lambda_, P, {0, 0, n, n}, work_);
    SmoothedState s{boxplus(x, correction), Covariance::Zero(n, n)};
    for (const Part& part : parts) {
      multiply(P, work_, part, s.P);
      auto here = s.P.block(part.row, part.column, part.rows, part.columns);
      here = P.block(part.row, part.column, part.rows, part.columns) - here;
    }
    const ResetJacobian G = reset_jacobian(correction);
    reset(s.P, layout_, G);
    turn_ = G.velocity_attitude.bottomRightCorner<3, 3>();
    return s;
  }

  bool traces() const { return traced_.cols() > 0; }
  FullError correction(const ErrorVector& mean, const Covariance& P) const {
    return expand(layout_, mean - P.lazyProduct(lambda_));
  }

  const StateLayout& layout_;
  bool covariance_;
  std::vector<Part> for_sigmas_;
  ErrorVector lambda_;
  Covariance Lambda_, work_;
  Eigen::MatrixXd traced_;  // three columns each
  Matrix3d turn_ = Matrix3d::Identity();
};

// Collects covariances of the attitude's errors at pairs of epochs: a few later epochs with many earlier ones.
class LagCollector {
 public:
  LagCollector(const World& world, std::size_t rows, std::vector<AttitudeLag>& lags)
      : world_(world),
        trace_every_(std::max<std::size_t>(1, rows / kLateEpochs)),
        look_every_(std::max<std::size_t>(1, rows / kEarlyEpochs)),
        last_(rows - 1),
        lags_(lags) {}

  /// To be called for every epoch, backwards, after it was smoothed.
  void visit(Backward& backward, std::size_t row, const Tape::Epoch& epoch, const SmoothedState& smoothed) {
    const bool traced = (last_ - row) % trace_every_ == 0;
    if (!traced && (last_ - row) % look_every_ != 0) return;
    const Matrix3d R_nw = world_.rotation_wn(smoothed.x.p_wb).transpose();
    const Matrix3d here = R_nw * attitude_of(smoothed) * R_nw.transpose();
    if (traced) {
      backward.trace(epoch.P);
      late_.push_back({row, epoch.time, R_nw, here});
    }
    const Eigen::Matrix3Xd covariance = R_nw * backward.lagged(epoch.P);
    for (std::size_t i = 0; i < late_.size(); ++i) {
      const Late& l = late_[i];
      lags_.push_back({row, l.row, l.time - epoch.time,
                       covariance.middleCols<3>(3 * static_cast<Eigen::Index>(i)) * l.R_nw.transpose(), here,
                       l.covariance});
    }
  }

 private:
  struct Late {
    std::size_t row;
    double time;
    Matrix3d R_nw, covariance;
  };
  static Matrix3d attitude_of(const SmoothedState& s) {
    constexpr int kAttitude = full_offset(Block::kAttitude);
    return s.P.block<3, 3>(kAttitude, kAttitude);
  }

  const World& world_;
  std::size_t trace_every_, look_every_, last_;
  std::vector<Late> late_;
  std::vector<AttitudeLag>& lags_;
};

// Runs the stretches of a filtered run again, last one first, and each of them backwards.
template <class AtEpoch>
void run_backwards(Backward& backward, const Log& log, const FilterRun& run, std::size_t first_row,
                   const ProgressCallback& progress, AtEpoch&& at_epoch) {
  if (run.checkpoints.empty()) throw std::logic_error("a smoother needs a run with checkpoints");
  const std::size_t rows = run.epochs;
  std::size_t end_row = rows;
  Tape tape;
  for (auto from = run.checkpoints.rbegin(); from != run.checkpoints.rend() && end_row > first_row; ++from) {
    tape.clear();
    rerun(log, *from, end_row, tape);
    backward.run(tape, end_row, at_epoch);
    end_row = from->row;
    if (progress) progress(1 - static_cast<double>(end_row) / static_cast<double>(rows));
  }
}

// Once the whole run has gone by.
SmoothedState smoothed_start(Backward& backward, const FilterRun& run) {
  const Filter& first = run.checkpoints.front().filter;
  return backward.smooth(first.estimate(), first.mean(), first.covariance());
}

}  // namespace

Solution smooth_rts(const Log& log, const FilterRun& run, const ProgressCallback& progress, SmoothedState* at_start,
                    std::vector<AttitudeLag>* lags) {
  const Solution& filtered = run.solution;
  Solution out(filtered.layout(), filtered.world());
  out.sources = filtered.sources;
  out.fixed = filtered.fixed;
  out.resize(run.epochs);
  Backward backward(filtered.layout());
  std::optional<LagCollector> collector;
  if (lags) collector.emplace(filtered.world(), run.epochs, *lags);
  run_backwards(backward, log, run, 0, progress, [&](std::size_t row, const Tape::Epoch& epoch) {
    const SmoothedState s = backward.smooth_for_sigmas(epoch.x, epoch.mean, epoch.P);
    out.set(row, epoch.time, s.x, sigmas_of(out.world(), s.x, out.layout(), s.P));
    if (collector) collector->visit(backward, row, epoch, s);
  });
  if (at_start) *at_start = smoothed_start(backward, run);
  return out;
}

Reference smoothed_trajectory(const Log& log, const FilterRun& run, const ProgressCallback& progress) {
  Backward backward(run.solution.layout(), false);
  std::vector<Reference::Row> rows(run.epochs);
  run_backwards(backward, log, run, 0, progress, [&](std::size_t row, const Tape::Epoch& epoch) {
    rows[row] = {epoch.time, backward.estimate(epoch.x, epoch.mean, epoch.P)};
  });
  const Filter& first = run.checkpoints.front().filter;
  return {std::move(rows), backward.estimate(first.estimate(), first.mean(), first.covariance())};
}

void smooth_rows(const Log& log, const FilterRun& run, const std::vector<std::size_t>& rows,
                 const EpochObserver& observer, SmoothedState* at_start) {
  Backward backward(run.solution.layout());
  auto next = rows.rbegin();
  const std::size_t first = at_start ? 0 : rows.empty() ? run.epochs : rows.front();
  run_backwards(backward, log, run, first, {}, [&](std::size_t row, const Tape::Epoch& epoch) {
    if (next == rows.rend() || *next != row) return;
    ++next;
    observer(row, epoch, backward.smooth(epoch.x, epoch.mean, epoch.P));
  });
  if (at_start) *at_start = smoothed_start(backward, run);
}

}  // namespace piste
