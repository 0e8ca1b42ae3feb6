#include "piste/smoother/rts.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "filter/reference.h"
#include "smoother/backward_pass.h"

namespace piste {
namespace {

// Collects covariances of the attitude's errors at pairs of epochs: a few late epochs, each with many earlier ones.
class LagCollector {
 public:
  LagCollector(const World& world, std::size_t rows, std::vector<AttitudeLag>& lags)
      : world_(world),
        trace_every_(std::max<std::size_t>(1, rows / kLateEpochs)),
        look_every_(std::max<std::size_t>(1, rows / kEarlyEpochs)),
        last_(rows - 1),
        lags_(lags) {}

  bool wants(std::size_t row) const { return (last_ - row) % trace_every_ == 0 || (last_ - row) % look_every_ == 0; }

  /// Call it for epochs backwards, after each was smoothed.
  void visit(BackwardPass& backward, std::size_t row, const FilterState& state, const SmoothedParts& smoothed) {
    if (!wants(row)) return;
    const bool traced = (last_ - row) % trace_every_ == 0;
    const Matrix3d R_nw = world_.rotation_wn(smoothed.x.p_wb).transpose();
    const Matrix3d here = R_nw * attitude_of(smoothed) * R_nw.transpose();
    if (traced) {
      backward.trace(state);
      late_.push_back({row, state.time, R_nw, here});
    }
    const Eigen::Matrix3Xd covariance = R_nw * backward.lagged(state.P);
    for (std::size_t i = 0; i < late_.size(); ++i) {
      const Late& l = late_[i];
      lags_.push_back({row, l.row, l.time - state.time,
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
  static Matrix3d attitude_of(const SmoothedParts& s) {
    constexpr int kAttitude = full_offset(Block::kAttitude);
    return s.P.block<3, 3>(kAttitude, kAttitude);
  }

  const World& world_;
  std::size_t trace_every_, look_every_, last_;
  std::vector<Late> late_;
  std::vector<AttitudeLag>& lags_;
};

void check(const FilterRun& run) {
  if (!run.history) throw std::logic_error("a smoother needs a run with its history");
}

// Reverses the order of the rows: a smoother finds the last row first.
class ReversedRows {
 public:
  ReversedRows(const Solution& like, const std::filesystem::path& scratch)
      : last_(like.layout(), like.world()), fixed_(like.fixed), scratch_(scratch) {
    last_.reserve(kRowsAtOnce);
  }
  void add(double time, const Estimate& x, const Sigmas& sigmas) {
    last_.append(time, x, sigmas);
    if (last_.size() == kRowsAtOnce) close();
  }
  void give(const RowTaker& rows) {
    close();
    std::vector<double> values;
    std::size_t first = 0;
    for (auto piece = pieces_.rbegin(); piece != pieces_.rend(); ++piece) {
      scratch_.read(*piece, values);
      Solution reversed(last_.layout(), last_.world());
      reversed.fixed = fixed_;
      const std::size_t stride = reversed.stride(), count = values.size() / stride;
      reversed.reserve(count);
      for (std::size_t i = count; i-- > 0;)
        reversed.append(std::span<const double>(values).subspan(i * stride, stride));
      rows(reversed, first);
      first += count;
    }
  }

 private:
  void close() {
    if (!last_.empty()) pieces_.push_back(scratch_.add(last_.rows()));
    last_.resize(0);
  }
  Solution last_;
  Estimate fixed_;
  Scratch scratch_;
  std::vector<std::size_t> pieces_;
};

// Writes all rows of a solution.
class ToSolution {
 public:
  ToSolution(BackwardPass& backward, const StateLayout& layout, Solution& out, ReversedRows* reversed,
             LagCollector* collector, SmoothedState* at_start)
      : backward_(backward),
        layout_(layout),
        out_(out),
        reversed_(reversed),
        collector_(collector),
        at_start_(at_start) {}

  BackwardPass::Want wants(std::size_t row) const {
    return collector_ != nullptr && collector_->wants(row) ? BackwardPass::Want::kWhole : BackwardPass::Want::kParts;
  }
  void seen(std::size_t row, double time, const SmoothedParts& s, const FilterState* whole) {
    const Sigmas sigmas = sigmas_of(out_.world(), s.x, layout_, s.P);
    if (reversed_ != nullptr) {
      reversed_->add(time, s.x, sigmas);
    } else {
      out_.set(row, time, s.x, sigmas);
    }
    if (collector_ != nullptr && whole != nullptr) collector_->visit(backward_, row, *whole, s);
  }
  void start(const FilterState& state) {
    if (at_start_) *at_start_ = backward_.smooth(state);
  }

 private:
  BackwardPass& backward_;
  const StateLayout& layout_;  // of the covariance
  Solution& out_;
  ReversedRows* reversed_;
  LagCollector* collector_;
  SmoothedState* at_start_;
};

}  // namespace

Solution smooth_rts(const FilterRun& run, const ProgressCallback& progress, SmoothedState* at_start,
                    std::vector<AttitudeLag>* lags, const RowTaker& rows) {
  check(run);
  const Solution& filtered = run.solution;
  Solution out(filtered.layout(), filtered.world());
  out.sources = filtered.sources;
  out.fixed = filtered.fixed;
  std::optional<ReversedRows> reversed;
  if (rows) {
    reversed.emplace(out, run.history->scratch());
  } else {
    out.resize(run.epochs);
  }
  BackwardPass backward(run);
  std::optional<LagCollector> collector;
  if (lags) collector.emplace(filtered.world(), run.epochs, *lags);
  backward.run(0, progress,
               ToSolution(backward, run.history->layout(), out, reversed ? &*reversed : nullptr,
                          collector ? &*collector : nullptr, at_start));
  if (reversed) reversed->give(rows);
  return out;
}

Reference smoothed_trajectory(const FilterRun& run, const ProgressCallback& progress) {
  check(run);
  BackwardPass backward(run, false);
  struct Visit {
    const BackwardPass& backward;
    Reference out;
    // The row that begins a chunk precedes those in it; all of these precede the rows of the next chunk.
    static BackwardPass::Want wants(std::size_t) { return BackwardPass::Want::kNothing; }
    void exact(std::size_t, const FilterState& state) {
      out.close();
      out.add(state.time, backward.estimate(state));
    }
    void start(const FilterState& state) {
      out.close();
      out.start = backward.estimate(state);
    }
    void between(std::size_t, double time, const Estimate& x) { out.add(time, x); }
  } visit{backward, Reference(run.solution.layout(), run.history->scratch())};
  backward.run(0, progress, visit);
  visit.out.close();
  return std::move(visit.out);
}

void smooth_rows(const FilterRun& run, const std::vector<std::size_t>& rows, const EpochObserver& observer,
                 SmoothedState* at_start) {
  check(run);
  BackwardPass backward(run);
  struct Visit {
    BackwardPass& backward;
    const std::vector<std::size_t>& rows;
    const EpochObserver& observer;
    SmoothedState* at_start;
    bool asked(std::size_t row) const { return std::binary_search(rows.begin(), rows.end(), row); }
    BackwardPass::Want wants(std::size_t row) const {
      return asked(row) ? BackwardPass::Want::kWhole : BackwardPass::Want::kNothing;
    }
    void seen(std::size_t row, double, const SmoothedParts&, const FilterState* whole) {
      if (asked(row)) observer(row, *whole, backward.smooth(*whole));
    }
    void start(const FilterState& state) {
      if (at_start) *at_start = backward.smooth(state);
    }
  };
  const std::size_t first = at_start ? 0 : rows.empty() ? run.epochs : rows.front();
  backward.run(first, {}, Visit{backward, rows, observer, at_start});
}

}  // namespace piste
