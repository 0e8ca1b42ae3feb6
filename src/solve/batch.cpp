#include "piste/solve/batch.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "batch_normal.h"
#include "batch_rows.h"
#include "batch_weights.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {

// Addresses in it stay the same when the run that owns it is moved.
struct BatchRun::Solved {
  World world;
  FilterOptions options;
  BatchLayout layout;
  Start start;
  Estimate fixed;  // values of the blocks that are not estimated
  std::vector<std::string> sources;
  Chain chain;
  std::unique_ptr<BatchTerms> terms;
  std::vector<double> weights;
  BatchStates states;
  BatchSummary summary;

  ArrowMatrix covariance() const { return covariance_of(*terms, weights, states); }
};

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

Reference reference_of(const Solution& filtered, const Start& start) {
  Reference out;
  out.start = start.x;
  out.rows.reserve(filtered.size());
  for (std::size_t i = 0; i < filtered.size(); ++i) out.rows.push_back({filtered.time(i), filtered.estimate(i)});
  return out;
}

std::vector<double> squares_of(const BatchTerms& terms, const BatchStates& states) {
  const auto& fixes = terms.chain().fixes;
  std::vector<double> out(fixes.size());
  for (std::size_t i = 0; i < fixes.size(); ++i) out[i] = terms.fix(i, states[fixes[i].node]).residual.squaredNorm();
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

}  // namespace

BatchRun::BatchRun() = default;
BatchRun::BatchRun(BatchRun&&) noexcept = default;
BatchRun& BatchRun::operator=(BatchRun&&) noexcept = default;
BatchRun::~BatchRun() = default;
BatchRun::BatchRun(std::unique_ptr<Solved> solved) : solved_(std::move(solved)) {}

const BatchSummary& BatchRun::summary() const { return solved_->summary; }

BatchRun run_batch(const Log& log, const FilterOptions& options, const FoundStart& found, const FilterRun& filtered,
                   const BatchOptions& batch, const ProgressCallback& progress) {
  auto solved = std::make_unique<BatchRun::Solved>(BatchRun::Solved{log.world,
                                                                    options,
                                                                    BatchLayout(filtered.solution.layout()),
                                                                    without_alignment(log.world, found),
                                                                    found.start.x,
                                                                    filtered.solution.sources,
                                                                    {},
                                                                    nullptr,
                                                                    {},
                                                                    {},
                                                                    {}});
  BatchRun::Solved& s = *solved;
  const FixWeights first_weights = weights_of_filter(filtered.solution, options);
  FixWeights known = first_weights;
  Reference reference = reference_of(filtered.solution, s.start);
  BatchSummary& sum = s.summary;
  while (sum.rounds < batch.most_rounds && !sum.converged) {
    s.chain = lay_chain(log, options, s.layout, s.start.time, reference, known, batch.longest_interval, s.chain.nodes);
    s.terms = std::make_unique<BatchTerms>(s.world, s.options, s.layout, s.start, s.chain);
    s.states.clear();
    s.states.reserve(s.chain.nodes.size());
    for (const ChainNode& node : s.chain.nodes) s.states.push_back(node.x);
    std::vector<double> at_first;
    at_first.reserve(s.chain.fixes.size());
    for (const ChainFix& fix : s.chain.fixes) at_first.push_back(known.at(key_of(fix)));
    BatchWeights weights(batch.loss, bounds_of(*s.terms, batch.bound), at_first, sum.rounds == 0);
    const auto solve = [&] {
      sum.iterations += minimise(*s.terms, weights.values(), s.states).iterations;
      return refine(*s.terms, weights.values(), s.states);
    };
    double cost = solve();
    constexpr int kMostWeighings = 50;
    bool changed = false;
    for (int k = 0; k < kMostWeighings && weights.update(squares_of(*s.terms, s.states)); ++k) {
      changed = true;
      cost = solve();
    }
    s.weights = weights.values();
    for (std::size_t i = 0; i < s.chain.fixes.size(); ++i) known[key_of(s.chain.fixes[i])] = s.weights[i];
    // Near the minimum the cost falls by half the square of what the solution moves, in sigmas.
    const double fell = std::abs(sum.cost - cost);
    sum.cost = cost;
    ++sum.rounds;
    sum.converged = sum.rounds > 1 && !changed && fell < batch.tolerance;
    if (!sum.converged) {
      reference = epochs_between(*s.terms, options, s.world, s.states);
      for (std::size_t i = 0; i < s.states.size(); ++i) s.chain.nodes[i].x = s.states[i];
    }
    if (progress) progress(static_cast<double>(sum.rounds) / (sum.rounds + 1));
  }
  sum.nodes = s.chain.nodes.size();
  sum.fixes = s.chain.fixes.size();
  for (std::size_t i = 0; i < s.weights.size(); ++i) {
    if (s.weights[i] < 0.5) ++sum.left_out;
    if (s.weights[i] >= 0.5 && first_weights.at(key_of(s.chain.fixes[i])) == 0) ++sum.taken_back;
  }
  return BatchRun(std::move(solved));
}

Solution BatchRun::solution(const ProgressCallback& progress) const {
  const Solved& s = *solved_;
  Solution out(s.layout.whole, s.world);
  out.sources = s.sources;
  out.fixed = s.fixed;
  out.batch = s.summary;
  std::vector<std::size_t> rows(s.chain.epochs.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  out.reserve(rows.size());
  constexpr std::size_t kTold = 1000;
  visit_epochs(*s.terms, s.options, s.world, s.states, s.covariance(), rows,
               [&](std::size_t row, double time, const SmoothedState& state) {
                 out.append(time, state.x, sigmas_of(s.world, state.x, s.layout.whole, state.P));
                 if (progress && row % kTold == 0) {
                   progress(static_cast<double>(row) / static_cast<double>(rows.size()));
                 }
               });
  return out;
}

std::vector<SmoothedState> BatchRun::states(const std::vector<std::size_t>& rows) const {
  const Solved& s = *solved_;
  std::vector<SmoothedState> out;
  out.reserve(rows.size());
  visit_epochs(*s.terms, s.options, s.world, s.states, s.covariance(), rows,
               [&](std::size_t, double, const SmoothedState& state) { out.push_back(state); });
  return out;
}

BatchSmoother batch_smoother(const BatchOptions& batch) {
  return [batch](const Log& log, const FilterOptions& options, const FoundStart& found, const FilterRun& filtered,
                 const ProgressCallback& progress) {
    constexpr double kSolving = 0.5;  // part of the work
    const BatchRun run = run_batch(log, options, found, filtered, batch, part_of(progress, 0, kSolving));
    return run.solution(part_of(progress, kSolving, 1));
  };
}

}  // namespace piste
