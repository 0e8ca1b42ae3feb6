#include "piste/batch/batch.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "filter/considered.h"
#include "lags.h"
#include "math/parallel.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "rows.h"
#include "weights.h"

namespace piste {

namespace {

// What the filter did with each fix that it compared: 1 if it used it, 0 if it refused it. What a receiver repeated is
// no measurement. A source that is never readmitted presumes something, such as rest or a wheel that rolls; where the
// filter refused it, that did not hold, and it stays out.
FixWeights weights_of_filter(const Solution& filtered, const FilterOptions& options) {
  const MeasurementSources sources(options);
  FixWeights out;
  for (const Innovation& i : filtered.innovations) {
    if (i.outcome == Outcome::kRepeated) continue;
    const bool used = was_used(i.outcome);
    if (used || sources.all()[static_cast<std::size_t>(i.source)].readmitted) {
      out[{i.source, i.time + i.late}] = used ? 1 : 0;
    }
  }
  return out;
}

// Its constants are what the filter has found in the end.
std::shared_ptr<const Reference> reference_of(const Solution& filtered, const BatchLayout& layout, const Start& start) {
  auto out = std::make_shared<Reference>(layout.whole);
  out->start = start.x;
  if (!filtered.empty()) layout.constant.copy(filtered.estimate(filtered.size() - 1), out->start);
  constexpr std::size_t kPiece = 1024;
  for (std::size_t end = filtered.size(); end > 0;) {
    const std::size_t first = end - std::min(end, kPiece);
    for (std::size_t i = first; i < end; ++i) out->add(filtered.time(i), filtered.estimate(i));
    out->close();
    end = first;
  }
  return out;
}

std::vector<double> bounds_of(const BatchTerms& terms, double probability) {
  std::array<double, 4> by_rows{};
  for (int n = 1; n <= 3; ++n) by_rows[static_cast<std::size_t>(n)] = chi_squared_quantile(probability, n);
  std::vector<double> out(terms.chain().fixes.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = by_rows[static_cast<std::size_t>(terms.rows_of_fix(i))];
  return out;
}

FixKey key_of(const ChainFix& fix) { return {fix.place.source, fix.place.time}; }

// The terms hold addresses of the other members, so that it stays where it is made.
struct SolvedBatch final : BatchRun {
  SolvedBatch(const Log& log, FilterOptions of_filter, const FoundStart& found, const FilterRun& filtered)
      : world(log.world),
        options(std::move(of_filter)),
        layout(filter_layout(options)),
        start(without_alignment(log.world, found)),
        fixed(found.start.x),
        sources(filtered.solution.sources) {}

  World world;
  FilterOptions options;
  BatchLayout layout;
  Start start;
  Estimate fixed;  // values of the blocks that are not estimated
  std::vector<std::string> sources;
  Chain chain;
  std::unique_ptr<BatchTerms> terms;
  BatchStates at_nodes;
  Newton newton;  // its equations are those near them
  BatchSummary sum;

  const BatchSummary& summary() const override { return sum; }
  Solution solution(const ProgressCallback& progress) const override;
  std::vector<SmoothedState> states(const std::vector<std::size_t>& rows) const override;
};

Solution SolvedBatch::solution(const ProgressCallback& progress) const {
  Solution out(StateLayout(options.estimate), world);
  out.sources = sources;
  out.fixed = fixed;
  out.batch = sum;
  std::vector<std::size_t> rows(chain.epochs.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  out.reserve(rows.size());
  constexpr std::size_t kReportedEvery = 1000;
  const ArrowMatrix P = newton.equations.covariance();
  out.attitude_correlation_time = correlation_time(attitude_lags(world, layout, chain, at_nodes, newton.equations, P));
  visit_epochs(*terms, options, world, at_nodes, P, rows,
               [&](std::size_t row, double time, const SmoothedState& state) {
                 out.append(time, state.x, sigmas_of(world, state.x, layout.whole, state.P));
                 if (progress && row % kReportedEvery == 0) {
                   progress(static_cast<double>(row) / static_cast<double>(rows.size()));
                 }
               });
  return out;
}

std::vector<SmoothedState> SolvedBatch::states(const std::vector<std::size_t>& rows) const {
  std::vector<SmoothedState> out;
  out.reserve(rows.size());
  visit_epochs(*terms, options, world, at_nodes, newton.equations.covariance(), rows,
               [&](std::size_t, double, const SmoothedState& state) { out.push_back(state); });
  for (SmoothedState& state : out) {  // what is considered is not part of the result
    for (const Block b : considered_blocks(options)) additive(state.x, b) = additive(fixed, b);
  }
  return out;
}

}  // namespace

std::unique_ptr<BatchRun> run_batch(const Log& log, const FilterOptions& options, const FoundStart& found,
                                    const FilterRun& filtered, const BatchOptions& batch,
                                    const ProgressCallback& progress, std::size_t threads) {
  auto solved = std::make_unique<SolvedBatch>(log, options, found, filtered);
  SolvedBatch& s = *solved;
  s.terms = std::make_unique<BatchTerms>(s.world, s.options, s.layout, s.start, s.chain);
  const FixWeights first_weights = weights_of_filter(filtered.solution, options);
  FixWeights known = first_weights;
  std::shared_ptr<const Reference> reference = reference_of(filtered.solution, s.layout, s.start);
  BatchSummary& sum = s.sum;
  bool smooth = true;
  std::vector<double> weighed;  // of the fixes, in the last round
  while (sum.rounds < batch.most_rounds && !sum.converged) {
    lay_chain(log, options, s.layout, s.start.time, reference, known, batch.longest_interval, threads, s.chain);
    s.at_nodes.clear();
    s.at_nodes.reserve(s.chain.nodes.size());
    // All share the constants: of what a filter found of them, the last.
    for (const ChainNode& node : s.chain.nodes) {
      s.at_nodes.push_back(node.x);
      s.layout.constant.copy(s.chain.nodes.back().x, s.at_nodes.back());
    }
    s.terms->follow_chain(s.at_nodes, threads);
    std::vector<double> at_first;
    at_first.reserve(s.chain.fixes.size());
    for (const ChainFix& fix : s.chain.fixes) at_first.push_back(known.at(key_of(fix)));
    BatchWeights weights(batch.loss, bounds_of(*s.terms, batch.bound), at_first, sum.rounds == 0);
    // By how much the objective fell. Steps of Gauss and Newton where they settle; from far off by a trust region
    // first, and always so where the objective has kinks, as an odometer without a sign has at a stand.
    const auto take = [&](const Refined& refined) {
      sum.cost = refined.cost;
      sum.iterations += refined.steps;
      return refined.fall;
    };
    const auto solve = [&]() -> double {
      if (smooth) {
        const Refined refined = refine(*s.terms, weights.values(), s.at_nodes, s.newton, WhereNot::kStays, threads);
        if (refined.settled) return take(refined);
      }
      const double before = sum.cost;
      const BatchStep far = minimise(*s.terms, weights.values(), s.at_nodes);
      sum.iterations += far.iterations;
      s.terms->linearise(s.at_nodes, threads);
      const Refined refined = refine(*s.terms, weights.values(), s.at_nodes, s.newton, WhereNot::kLowest, threads);
      const double fell = take(refined);
      smooth = refined.settled;
      return smooth ? far.before - far.after + fell : std::abs(before - sum.cost);
    };
    const double moved = solve();
    // New weights are tried with the derivatives of the last step, as long as these hold. The last ones are those of a
    // solution with its own.
    constexpr int kMostWeighings = 50;
    bool changed = false, own = true;
    for (int k = 0; k < kMostWeighings; ++k) {
      if (weights.update(squares_of(*s.terms, s.newton, threads))) {
        changed = true;
        if (smooth) {
          const Refined refined = reweigh(*s.terms, weights.values(), s.at_nodes, s.newton, threads);
          take(refined);
          own = false;
          if (refined.settled) continue;
        }
      } else if (own) {
        break;
      }
      s.terms->linearise(s.at_nodes, threads);
      solve();
      own = true;
    }
    weighed = weights.values();
    for (std::size_t i = 0; i < s.chain.fixes.size(); ++i) known[key_of(s.chain.fixes[i])] = weighed[i];
    ++sum.rounds;
    sum.converged = sum.rounds > 1 && !changed && moved < by_nodes(batch.tolerance, s.at_nodes.size());
    if (!sum.converged) {
      reference = epochs_between(*s.terms, options, s.world, s.at_nodes, threads);
      for (std::size_t i = 0; i < s.at_nodes.size(); ++i) s.chain.nodes[i].x = s.at_nodes[i];
    }
    if (progress) progress(static_cast<double>(sum.rounds) / (sum.rounds + 1));
  }
  if (!smooth) eliminate(*s.terms, weighed, s.newton, true, threads);
  sum.nodes = s.chain.nodes.size();
  sum.fixes = s.chain.fixes.size();
  for (std::size_t i = 0; i < weighed.size(); ++i) {
    if (weighed[i] < 0.5) ++sum.left_out;
    if (weighed[i] >= 0.5 && first_weights.at(key_of(s.chain.fixes[i])) == 0) ++sum.taken_back;
  }
  return solved;
}

BatchSolver batch_solver(const BatchOptions& batch, std::size_t threads) {
  return [batch, threads](const Log& log, const FilterOptions& options, const FoundStart& found,
                          const FilterRun& filtered, const ProgressCallback& progress) {
    return run_batch(log, options, found, filtered, batch, progress, threads);
  };
}

}  // namespace piste
