#include "piste/consistency/consistency.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>
#include <type_traits>

#include "consistency/report_numbers.h"
#include "piste/core/error.h"

namespace piste {
namespace {

constexpr std::size_t kPhases = kPhaseNames.size();
constexpr double kHeadingTime = 5;  // s after the departure
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view kMagic = "piste consistency 1\n";

// Columns of Consistency::source_sums_, and of heading_.
enum SourceTerm { kDof, kCount, kRejected, kNis, kPairs, kProduct, kPower = kProduct + 3, kSourceTerms = kPower + 3 };
enum HeadingTerm { kRuns, kSquare, kLargest, kLargestSigma, kLargestRatio, kHeadingTerms };

std::size_t index(int i) { return static_cast<std::size_t>(i); }
std::size_t index(Phase phase) { return static_cast<std::size_t>(phase); }

// eᵀ P⁻¹ e of some rows, scaled to correlations first: the blocks' units differ by many orders.
double nees(const ErrorSample& s, const std::vector<int>& rows) {
  const ErrorVector e = s.error(rows);
  const Covariance P = s.P(rows, rows);
  const ErrorVector scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const ErrorVector z = scale.cwiseProduct(e);
  const Covariance correlation = scale.asDiagonal() * P * scale.asDiagonal();
  return z.dot(correlation.ldlt().solve(z));
}

// Mean of n values and its standard error, from their sum and the sum of their squares.
std::pair<double, double> mean_of(double sum, double squares, double n) {
  const double mean = sum / n;
  const double variance = n > 1 ? std::max(0.0, squares / n - mean * mean) / (n - 1) : kNaN;
  return {mean, std::sqrt(variance)};
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

bool SourceConsistency::white() const {
  return std::all_of(autocorrelation.begin(), autocorrelation.begin() + dof,
                     [this](double r) { return std::abs(r) < autocorrelation_band; });
}

std::vector<std::string> ConsistencyReport::outside() const {
  std::vector<std::string> out;
  const auto judge = [&](const EstimatorConsistency& estimator, const std::string& name) {
    const auto& found = estimator.groups[index(Phase::kUnderWay)];
    for (std::size_t g = 0; g < found.size(); ++g) {
      if (!bands[g].contains(found[g].nees)) out.push_back(name + " " + groups[g].name);
    }
  };
  judge(filter, "filter");
  judge(smoother, "smoother");
  return out;
}

bool ConsistencyReport::consistent() const {
  const auto seen = [](const EstimatorConsistency& e) { return !e.groups[index(Phase::kUnderWay)].empty(); };
  return failures.empty() && seen(filter) && seen(smoother) && outside().empty();
}

// ---- Adding up ----

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
    for (auto* table : {&s->mean, &s->mean_square, &s->errors, &s->largest}) table->assign(kPhases * groups, 0);
    s->within.assign(kPhases * groups * 3, 0);
    for (auto* table : {&s->ratio, &s->ratio_square}) table->assign(kPhases * layout_.blocks().size(), 0);
  }
}

void Consistency::prepare(const ComparedRun& run) {
  if (groups_.empty()) allot(run.layout, run.sources);
  if (run.layout.blocks() != layout_.blocks() || run.sources != sources_) {
    throw DataError("ensemble", "all runs must estimate the same blocks from the same sources");
  }
}

void Consistency::add(const ComparedRun& run) {
  prepare(run);
  ++runs_;
  add(filter_, run.filtered);
  add(smoother_, run.smoothed);
  add_innovations(run);
  add_heading(run.filtered);
}

void Consistency::add(Sums& sums, const std::vector<ErrorSample>& samples) const {
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
  for (const Innovation& v : run.innovations) {
    if (!grid_.cruise.contains(v.time)) continue;
    double* sums = &source_sums_[index(v.source) * kSourceTerms];
    sums[kDof] = v.dof;
    ++sums[kCount];
    sums[kRejected] += was_used(v.outcome) ? 0 : 1;
    sums[kNis] += v.nis / v.dof;
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

// ---- What they say ----

namespace {

// Of sums of squares over `count` samples.
BlockAccuracy root_mean(const BlockAccuracy& sum, double count) {
  return {std::sqrt(sum.rmse / count), std::sqrt(sum.bound / count), std::sqrt(sum.claimed / count),
          std::sqrt(sum.rmse / sum.bound), kNaN};
}

}  // namespace

EstimatorConsistency Consistency::summarise(const Sums& sums, double probability) const {
  EstimatorConsistency out;
  const std::size_t groups = groups_.size(), states = index(layout_.size()), blocks = layout_.blocks().size();
  const std::size_t epochs = index(grid_.size());
  out.nees.assign(groups, std::vector<double>(epochs, kNaN));
  out.accuracy.assign(blocks, std::vector<BlockAccuracy>(epochs, {kNaN, kNaN, kNaN, kNaN, kNaN}));
  std::array<std::vector<double>, kPhases> outside;
  std::array<std::vector<BlockAccuracy>, kPhases> total;
  std::array<double, kPhases> samples{};
  for (std::size_t p = 0; p < kPhases; ++p) {
    outside[p].assign(groups, 0);
    total[p].assign(blocks, {});
  }
  std::array<double, kPhases> phase_epochs{};
  for (std::size_t e = 0; e < epochs; ++e) {
    const double n = sums.runs[e];
    if (n == 0) continue;
    const auto phase = grid_.phase(grid_.time(grid_.first + static_cast<int>(e)));
    if (phase) ++phase_epochs[index(*phase)];
    for (std::size_t g = 0; g < groups; ++g) {
      const double mean = out.nees[g][e] = sums.nees[e * groups + g] / n;
      const Band band = chi_squared_band(probability, static_cast<double>(groups_[g].rows.size()), n);
      if (phase && !band.contains(mean)) ++outside[index(*phase)][g];
    }
    for (std::size_t b = 0; b < blocks; ++b) {
      const Block block = layout_.blocks()[b];
      BlockAccuracy sum;
      for (int i = layout_.offset(block); i < layout_.offset(block) + info(block).size; ++i) {
        sum.rmse += sums.square[e * states + index(i)];
        sum.bound += sums.bound[e * states + index(i)];
        sum.claimed += sums.claimed[e * states + index(i)];
      }
      out.accuracy[b][e] = root_mean(sum, n);
      if (!phase) continue;
      BlockAccuracy& all = total[index(*phase)][b];
      all.rmse += sum.rmse;
      all.bound += sum.bound;
      all.claimed += sum.claimed;
    }
    if (phase) samples[index(*phase)] += n;
  }
  for (std::size_t p = 0; p < kPhases; ++p) {
    if (sums.phase_runs[p] == 0) continue;
    for (std::size_t g = 0; g < groups; ++g) {
      const std::size_t at = p * groups + g;
      GroupConsistency found;
      std::tie(found.nees, found.standard_error) = mean_of(sums.mean[at], sums.mean_square[at], sums.phase_runs[p]);
      found.outside = outside[p][g] / phase_epochs[p];
      for (std::size_t k = 0; k < 3; ++k) found.coverage[k] = sums.within[3 * at + k] / sums.errors[at];
      found.largest = sums.largest[at];
      out.groups[p].push_back(found);
    }
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t at = p * blocks + b;
      BlockAccuracy found = root_mean(total[p][b], samples[p]);
      const double spread = mean_of(sums.ratio[at], sums.ratio_square[at], sums.phase_runs[p]).second;
      found.standard_error = 0.5 * spread / found.ratio;
      out.blocks[p].push_back(found);
    }
  }
  return out;
}

ConsistencyReport Consistency::report(double probability) const {
  ConsistencyReport out;
  out.runs = static_cast<int>(runs_);
  out.probability = probability;
  out.grid = grid_;
  out.layout = layout_;
  out.groups = groups_;
  out.failures = failures_;
  if (runs_ == 0) return out;
  for (const StateGroup& g : groups_) {
    out.bands.push_back(chi_squared_band(probability, static_cast<double>(g.rows.size()), runs_));
  }
  out.filter = summarise(filter_, probability);
  out.smoother = summarise(smoother_, probability);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const double* sums = &source_sums_[s * kSourceTerms];
    if (sums[kCount] == 0) continue;
    SourceConsistency source{.name = sources_[s],
                             .dof = static_cast<int>(sums[kDof]),
                             .count = sums[kCount],
                             .rejected = sums[kRejected],
                             .nis = sums[kNis] / sums[kCount],
                             .band = chi_squared_band(probability, sums[kDof], sums[kCount])};
    for (std::size_t i = 0; i < index(source.dof); ++i) {
      source.autocorrelation[i] = sums[kProduct + i] / sums[kPower + i];
    }
    source.autocorrelation_band = normal_quantile(0.5 * (1 + probability)) / std::sqrt(std::max(1.0, sums[kPairs]));
    out.sources.push_back(source);
  }
  if (const double n = heading_[kRuns]; n > 0) {
    out.heading = {
        kHeadingTime,           n, std::sqrt(heading_[kSquare] / n), heading_[kLargest], heading_[kLargestSigma],
        heading_[kLargestRatio]};
  }
  return out;
}

// ---- As bytes ----

namespace {

template <class T>
void put(std::string& bytes, const T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  } else {
    put(bytes, value.size());
    for (const auto& item : value) put(bytes, item);
  }
}

// Takes what was put from the front.
template <class T>
void take(std::string_view& bytes, T& value) {
  if constexpr (std::is_arithmetic_v<T>) {
    if (bytes.size() < sizeof value) throw DataError("ensemble", "the saved sums are cut short");
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes.remove_prefix(sizeof value);
  } else {
    std::size_t size = 0;
    take(bytes, size);
    if (size > bytes.size()) throw DataError("ensemble", "the saved sums are cut short");
    value.resize(size);
    for (auto& item : value) take(bytes, item);
  }
}

}  // namespace

template <class Self, class Visitor>
void Consistency::visit(Self& self, Visitor&& visit) {
  visit(self.grid_.step), visit(self.grid_.first), visit(self.grid_.last);
  visit(self.grid_.cruise.start), visit(self.grid_.cruise.end), visit(self.grid_.arrival);
  visit(self.runs_);
  for (auto* s : {&self.filter_, &self.smoother_}) {
    for (auto* table : {&s->runs, &s->nees, &s->square, &s->bound, &s->claimed, &s->phase_runs, &s->mean,
                        &s->mean_square, &s->errors, &s->within, &s->largest, &s->ratio, &s->ratio_square}) {
      visit(*table);
    }
  }
  visit(self.sources_), visit(self.source_sums_), visit(self.heading_);
}

std::string Consistency::save() const {
  std::string bytes(kMagic);
  visit(*this, [&](const auto& value) { put(bytes, value); });
  put(bytes, layout_.blocks().size());
  for (const Block b : layout_.blocks()) put(bytes, index_of(b));
  put(bytes, failures_.size());
  for (const FailedRun& f : failures_) {
    put(bytes, f.seed);
    put(bytes, f.what);
  }
  return bytes;
}

Consistency Consistency::restore(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) throw DataError("ensemble", "these are no saved sums");
  bytes.remove_prefix(kMagic.size());
  Consistency out{EpochGrid{}};
  visit(out, [&](auto& value) { take(bytes, value); });
  std::vector<int> blocks;
  take(bytes, blocks);
  std::vector<Block> layout;
  for (const int b : blocks) {
    if (b < 0 || b >= kBlockCount) throw DataError("ensemble", "the saved sums name an unknown block");
    layout.push_back(static_cast<Block>(b));
  }
  if (out.runs_ > 0) {  // else nothing is allotted yet
    Consistency fitting(out.grid_);
    if (index(out.grid_.size()) == out.filter_.runs.size()) fitting.allot(StateLayout(layout), out.sources_);
    const auto sizes = [](const Consistency& of) {
      std::vector<std::size_t> all;
      visit(of, [&](const auto& value) {
        if constexpr (requires { value.size(); }) all.push_back(value.size());
      });
      return all;
    };
    if (sizes(out) != sizes(fitting)) throw DataError("ensemble", "the saved sums do not fit one another");
    out.layout_ = fitting.layout_;
    out.groups_ = fitting.groups_;
  }
  std::size_t failures = 0;
  take(bytes, failures);
  for (std::size_t i = 0; i < failures; ++i) {
    FailedRun failure;
    take(bytes, failure.seed);
    take(bytes, failure.what);
    out.failures_.push_back(std::move(failure));
  }
  if (!bytes.empty()) throw DataError("ensemble", "the saved sums go on where they should end");
  return out;
}

std::string consistency_verdict(const ConsistencyReport& report) {
  const std::string band = fmt::format("{} band", percent(report.probability));
  if (report.consistent()) {
    return fmt::format("Consistent: over {} runs, under way, the NEES of every group lies within its {}.", report.runs,
                       band);
  }
  std::vector<std::string> reasons;
  constexpr auto kSeen = static_cast<std::size_t>(Phase::kUnderWay);
  for (const auto& [name, estimator] : {std::pair{"filter", &report.filter}, {"smoother", &report.smoother}}) {
    if (estimator->groups[kSeen].empty()) reasons.push_back(fmt::format("the {} was not seen under way", name));
  }
  constexpr std::size_t kNamed = 6;
  auto outside = report.outside();
  if (!outside.empty()) {
    const std::size_t more = outside.size() - std::min(outside.size(), kNamed);
    outside.resize(outside.size() - more);
    if (more > 0) outside.back() += fmt::format(" and {} more", more);
    reasons.push_back(fmt::format("over {} runs, under way, the NEES of {} lies outside its {}", report.runs,
                                  fmt::join(outside, ", "), band));
  }
  if (!report.failures.empty()) {
    reasons.push_back(fmt::format("{} of {} runs failed", report.failures.size(),
                                  report.failures.size() + static_cast<std::size_t>(report.runs)));
  }
  return fmt::format("Not consistent: {}.", fmt::join(reasons, "; "));
}

}  // namespace piste
