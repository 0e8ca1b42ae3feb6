// Computes the statistics of an ensemble from its sums.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "piste/consistency/consistency.h"
#include "piste/math/statistics.h"
#include "sums.h"

namespace piste {
namespace {

// Mean of n values and its standard error, from their sum and the sum of their squares.
std::pair<double, double> mean_of(double sum, double squares, double n) {
  const double mean = sum / n;
  const double variance = n > 1 ? std::max(0.0, squares / n - mean * mean) / (n - 1) : kNaN;
  return {mean, std::sqrt(variance)};
}

// Of sums of squares over `count` samples.
BlockAccuracy root_mean(const BlockAccuracy& sum, double count) {
  return {std::sqrt(sum.rmse / count), std::sqrt(sum.bound / count), std::sqrt(sum.claimed / count),
          std::sqrt(sum.rmse / sum.bound), kNaN};
}

constexpr double kSmallNees = 0.05, kSmallNis = 0.02;  // differences from 1 that nobody would act on
constexpr Band kFairAtRest{0.8, 1.25};

struct Judged {
  double mean, standard_error;
  MeanTest* test;
  bool small;
  Band band;  // of a mean of as many runs whose errors do not change in a run
};

void judge(const std::vector<Judged>& all, double runs, double probability) {
  std::vector<double> p;
  p.reserve(all.size());
  for (const Judged& j : all) {
    const bool known = runs > 1 && j.standard_error > 0;
    p.push_back(known ? student_two_sided(std::abs(j.mean - 1) / j.standard_error, runs - 1) : kNaN);
  }
  p = holm(std::move(p));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool significant = p[i] < 1 - probability;
    *all[i].test = {p[i], (all[i].small || !significant) && all[i].band.contains(all[i].mean)};
  }
}

void judge(ConsistencyReport& report) {
  const auto groups = [&](std::initializer_list<Phase> phases, auto&& small) {
    std::vector<Judged> all;
    for (EstimatorConsistency* estimator : {&report.filter, &report.smoother}) {
      for (const Phase phase : phases) {
        std::vector<GroupConsistency>& found = estimator->groups[index(phase)];
        for (std::size_t g = 0; g < found.size(); ++g) {
          all.push_back(
              {found[g].nees, found[g].standard_error, &found[g].test, small(found[g].nees), report.bands[g]});
        }
      }
    }
    judge(all, report.runs, report.probability);
  };
  groups({Phase::kUnderWay}, [](double nees) { return std::abs(nees - 1) < kSmallNees; });
  groups({Phase::kRest, Phase::kRestAfter}, [](double nees) { return kFairAtRest.contains(nees); });
  std::vector<Judged> sources;
  for (SourceConsistency& s : report.sources) {
    sources.push_back({s.nis,
                       s.standard_error,
                       &s.test,
                       std::abs(s.nis - 1) < kSmallNis,
                       {0, std::numeric_limits<double>::infinity()}});
  }
  judge(sources, report.runs, report.probability);
}

}  // namespace

bool SourceConsistency::white() const {
  return std::all_of(autocorrelation.begin(), autocorrelation.begin() + dof,
                     [this](double r) { return std::abs(r) < autocorrelation_band; });
}

std::vector<std::string> ConsistencyReport::outside() const {
  std::vector<std::string> out;
  const auto judge = [&](const EstimatorConsistency& estimator, const std::string& name) {
    const auto& found = estimator.groups[index(Phase::kUnderWay)];
    for (std::size_t g = 0; g < found.size(); ++g) {
      if (!found[g].test.holds) out.push_back(name + " " + groups[g].name);
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
      found.largest_seed = static_cast<std::uint64_t>(sums.largest_seed[at]);
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
                             .standard_error = mean_of(sums[kRunNis], sums[kRunSquare], sums[kRunsSeen]).second,
                             .test = {},
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
  judge(out);
  return out;
}

}  // namespace piste
