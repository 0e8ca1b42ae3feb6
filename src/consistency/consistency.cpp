#include "piste/consistency/consistency.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "math/linear_algebra.h"
#include "piste/core/error.h"
#include "sums.h"

namespace piste {
namespace {

// eᵀ P⁻¹ e of some rows, scaled to correlations first: the blocks' units differ by many orders.
double nees(const ErrorSample& s, const std::vector<int>& rows) {
  const ErrorVector e = s.error(rows);
  const Covariance P = s.P(rows, rows);
  const ErrorVector scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const ErrorVector z = scale.cwiseProduct(e);
  const Covariance correlation = scale.asDiagonal() * P * scale.asDiagonal();
  return z.dot(solve_symmetric(correlation, Eigen::VectorXd(z)));
}

}  // namespace

std::optional<Phase> EpochGrid::phase(double time) const {
  if (time < 0) return Phase::kRest;
  if (cruise.contains(time)) return Phase::kUnderWay;
  if (time > arrival) return Phase::kRestAfter;
  return std::nullopt;
}

std::optional<Interval> EpochGrid::interval(Phase wanted) const {
  std::optional<Interval> out;
  for (int epoch = first; epoch <= last; ++epoch) {
    const double t = time(epoch);
    if (phase(t) == wanted) out = Interval{out ? out->start : t, t};
  }
  return out;
}

std::vector<StateGroup> state_groups(const StateLayout& layout) {
  std::vector<StateGroup> groups;
  const auto add = [&](std::string name, const std::vector<Block>& blocks) {
    StateGroup group{std::move(name), {}};
    for (const Block b : blocks) {
      for (int i = 0; layout.has(b) && i < info(b).size; ++i) group.rows.push_back(layout.offset(b) + i);
    }
    if (!group.rows.empty()) groups.push_back(std::move(group));
  };
  add("whole", layout.blocks());
  add("navigation", {Block::kPosition, Block::kVelocity, Block::kAttitude});
  add("biases", {Block::kGyroBias, Block::kAccelBias, Block::kGyroDrift, Block::kAccelDrift});
  add("scales", {Block::kGyroScale, Block::kAccelScale});
  for (const Block b : layout.blocks()) add(std::string(info(b).name), {b});
  return groups;
}

void Consistency::allot(const StateLayout& layout, std::vector<std::string> sources) {
  layout_ = layout;
  groups_ = state_groups(layout_);
  sources_ = std::move(sources);
  source_sums_.assign(sources_.size() * kSourceTerms, 0);
  heading_.assign(kHeadingTerms, 0);
  for (Sums* s : {&filter_, &smoother_}) {
    const std::size_t epochs = index(grid_.size()), groups = groups_.size(), states = index(layout_.size());
    s->runs.assign(epochs, 0);
    s->nees.assign(epochs * groups, 0);
    for (auto* table : {&s->square, &s->bound, &s->claimed}) table->assign(epochs * states, 0);
    s->phase_runs.assign(kPhases, 0);
    for (auto* table : {&s->mean, &s->mean_square, &s->errors, &s->largest, &s->largest_seed})
      table->assign(kPhases * groups, 0);
    s->within.assign(kPhases * groups * 3, 0);
    for (auto* table : {&s->ratio, &s->ratio_square}) table->assign(kPhases * layout_.blocks().size(), 0);
  }
}

void Consistency::prepare(const StateLayout& layout, const std::vector<std::string>& sources) {
  if (groups_.empty()) allot(layout, sources);
  if (layout.blocks() != layout_.blocks() || sources != sources_) {
    throw DataError("ensemble", "all runs must estimate the same blocks from the same sources");
  }
}

void Consistency::append(const Consistency& other) {
  const auto times = [](const EpochGrid& g) {
    return std::array{g.step, g.time(g.first), g.time(g.last), g.cruise.start, g.cruise.end, g.arrival};
  };
  if (times(grid_) != times(other.grid_)) throw DataError("ensemble", "all runs must be looked at at the same times");
  failures_.insert(failures_.end(), other.failures_.begin(), other.failures_.end());
  if (other.runs_ == 0) return;
  prepare(other.layout_, other.sources_);
  runs_ += other.runs_;
  const auto plus = [](std::vector<double>& sum, const std::vector<double>& more) {
    std::transform(sum.begin(), sum.end(), more.begin(), sum.begin(), std::plus<>());
  };
  const auto most = [](double& largest, double more) { largest = std::max(largest, more); };
  for (const auto& [sums, more] : {std::pair{&filter_, &other.filter_}, std::pair{&smoother_, &other.smoother_}}) {
    for (const auto table :
         {&Sums::runs, &Sums::nees, &Sums::square, &Sums::bound, &Sums::claimed, &Sums::phase_runs, &Sums::mean,
          &Sums::mean_square, &Sums::errors, &Sums::within, &Sums::ratio, &Sums::ratio_square}) {
      plus(sums->*table, more->*table);
    }
    for (std::size_t i = 0; i < sums->largest.size(); ++i) {
      if (more->largest[i] > sums->largest[i]) sums->largest_seed[i] = more->largest_seed[i];
      most(sums->largest[i], more->largest[i]);
    }
  }
  for (std::size_t i = 0; i < source_sums_.size(); ++i) {
    if (i % kSourceTerms == kDof) {
      most(source_sums_[i], other.source_sums_[i]);
    } else {
      source_sums_[i] += other.source_sums_[i];
    }
  }
  for (const HeadingTerm term : {kRuns, kSquare}) heading_[term] += other.heading_[term];
  for (const HeadingTerm term : {kLargest, kLargestSigma, kLargestRatio}) most(heading_[term], other.heading_[term]);
}

void Consistency::add(const ComparedRun& run) {
  prepare(run.layout, run.sources);
  ++runs_;
  add(filter_, run.filtered, run.seed);
  add(smoother_, run.smoothed, run.seed);
  add_innovations(run);
  add_heading(run.filtered);
}

void Consistency::add(Sums& sums, const std::vector<ErrorSample>& samples, std::uint64_t seed) const {
  const std::size_t groups = groups_.size(), states = index(layout_.size()), blocks = layout_.blocks().size();
  // Of this run, by phase.
  std::array<double, kPhases> epochs{};
  std::vector<double> group_sum(kPhases * groups), square(kPhases * blocks), bound(kPhases * blocks);
  for (const ErrorSample& s : samples) {
    const std::size_t epoch = index(s.epoch - grid_.first);
    const auto phase = grid_.phase(grid_.time(s.epoch));
    ++sums.runs[epoch];
    if (phase) ++epochs[index(*phase)];
    const ErrorVector z = (s.error.array() / s.P.diagonal().array().sqrt()).abs();
    for (std::size_t g = 0; g < groups; ++g) {
      const std::vector<int>& rows = groups_[g].rows;
      const double value = nees(s, rows) / static_cast<double>(rows.size());
      sums.nees[epoch * groups + g] += value;
      if (!phase) continue;
      const std::size_t at = index(*phase) * groups + g;
      group_sum[at] += value;
      for (const int row : rows) {
        ++sums.errors[at];
        for (std::size_t k = 0; k < 3; ++k) sums.within[3 * at + k] += z(row) < static_cast<double>(k + 1) ? 1 : 0;
        if (z(row) > sums.largest[at]) sums.largest_seed[at] = static_cast<double>(seed);
        sums.largest[at] = std::max(sums.largest[at], z(row));
      }
    }
    for (std::size_t i = 0; i < states; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      sums.square[epoch * states + i] += s.error(row) * s.error(row);
      sums.bound[epoch * states + i] += s.bound(row);
      sums.claimed[epoch * states + i] += s.P(row, row);
    }
    for (std::size_t b = 0; phase && b < blocks; ++b) {
      const Block block = layout_.blocks()[b];
      const std::size_t at = index(*phase) * blocks + b;
      square[at] += s.error.segment(layout_.offset(block), info(block).size).squaredNorm();
      bound[at] += s.bound.segment(layout_.offset(block), info(block).size).sum();
    }
  }
  for (std::size_t p = 0; p < kPhases; ++p) {
    if (epochs[p] == 0) continue;
    ++sums.phase_runs[p];
    for (std::size_t at = p * groups; at < (p + 1) * groups; ++at) {
      const double mean = group_sum[at] / epochs[p];
      sums.mean[at] += mean;
      sums.mean_square[at] += mean * mean;
    }
    for (std::size_t at = p * blocks; at < (p + 1) * blocks; ++at) {
      const double ratio = square[at] / bound[at];
      sums.ratio[at] += ratio;
      sums.ratio_square[at] += ratio * ratio;
    }
  }
}

void Consistency::add_innovations(const ComparedRun& run) {
  std::vector<std::optional<Vector3d>> before(sources_.size());
  std::vector<std::pair<double, double>> own(sources_.size());  // of this run: count, and sum of the NIS
  for (const Innovation& v : run.innovations) {
    if (!grid_.cruise.contains(v.time)) continue;
    double* sums = &source_sums_[index(v.source) * kSourceTerms];
    sums[kDof] = v.dof;
    ++sums[kCount];
    sums[kRejected] += was_used(v.outcome) ? 0 : 1;
    sums[kNis] += v.nis / v.dof;
    own[index(v.source)].first += 1;
    own[index(v.source)].second += v.nis / v.dof;
    Vector3d z = Vector3d::Zero();
    z.head(v.dof) = v.residual.head(v.dof).cwiseQuotient(v.sigma.head(v.dof));
    auto& last = before[index(v.source)];
    if (last) {
      ++sums[kPairs];
      for (int i = 0; i < v.dof; ++i) {
        sums[kProduct + i] += z(i) * (*last)(i);
        sums[kPower + i] += z(i) * z(i);
      }
    }
    last = z;
  }
  for (std::size_t s = 0; s < own.size(); ++s) {
    if (own[s].first == 0) continue;
    const double mean = own[s].second / own[s].first;
    double* sums = &source_sums_[s * kSourceTerms];
    ++sums[kRunsSeen];
    sums[kRunNis] += mean;
    sums[kRunSquare] += mean * mean;
  }
}

void Consistency::add_heading(const std::vector<ErrorSample>& filtered) {
  const int epoch = static_cast<int>(std::ceil(kHeadingTime / grid_.step - 1e-9));
  const auto sample =
      std::find_if(filtered.begin(), filtered.end(), [epoch](const ErrorSample& s) { return s.epoch == epoch; });
  if (sample == filtered.end()) return;
  const int down = layout_.offset(Block::kAttitude) + 2;
  const double error = std::abs(sample->error(down)), sigma = std::sqrt(sample->P(down, down));
  ++heading_[kRuns];
  heading_[kSquare] += error * error;
  heading_[kLargest] = std::max(heading_[kLargest], error);
  heading_[kLargestSigma] = std::max(heading_[kLargestSigma], sigma);
  heading_[kLargestRatio] = std::max(heading_[kLargestRatio], error / sigma);
}

}  // namespace piste
