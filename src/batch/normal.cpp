#include "normal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "math/parallel.h"
#include "math/task_queue.h"
#include "piste/core/error.h"

namespace piste {
namespace {

// Nodes that are written down, and then eliminated, while they are near in memory.
constexpr std::size_t kStretch = 32;

// The fixes and the prior of the nodes from `first` to before `last`.
void write_down(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& at, std::size_t first,
                std::size_t last, ArrowEquations& out) {
  const std::vector<ChainFix>& fixes = terms.chain().fixes;
  out.reset(last - first, terms.layout().node.size(), terms.layout().constant.size());
  if (first == 0) {
    const BatchTerm prior = terms.prior(at.front());
    out.add(0, prior.by_first, prior.by_constant, prior.residual);
  }
  const auto before = [first](const ChainFix& fix) { return fix.node < first; };
  auto i = static_cast<std::size_t>(std::partition_point(fixes.begin(), fixes.end(), before) - fixes.begin());
  for (; i < fixes.size() && fixes[i].node < last; ++i) {
    if (weights[i] > 0) out.add(fixes[i].node - first, terms.fixes(), i, weights[i]);
  }
}

// Half the square of seven sigmas of all unknowns of a thousand nodes together: what such a step leaves is of its
// second order, so much less, and the next round, which lays the run out anew, takes it away.
constexpr double kSettled = 25;

void take_step(const BatchLayout& layout, Newton& newton, BatchStates& states, std::size_t threads) {
  newton.step = newton.equations.solution();
  for_each_stretch(states.size(), kPerTask, threads, [&](std::size_t begin, std::size_t end) {
    ErrorVector error(layout.whole.size());
    layout.constant.put(newton.step.border.data(), error);
    for (std::size_t i = begin; i < end; ++i) {
      layout.node.put(newton.step.nodes[i].data(), error);
      states[i] = boxplus(newton.at[i], layout.whole, error);
    }
  });
}

}  // namespace

double eliminate(const BatchTerms& terms, const std::vector<double>& weights, Newton& newton, bool anew,
                 std::size_t threads) {
  constexpr Eigen::Index kNavigation = 9;  // what is not diagonal in a transition
  const BatchStates& at = newton.at;
  ArrowElimination& out = newton.equations;
  out.begin(at.size(), terms.layout().node.size(), terms.layout().constant.size(), kNavigation);
  // One stretch is written down while others wait for another thread, which eliminates them in their order.
  constexpr std::size_t kMostWait = 4;
  std::vector<ArrowEquations> stretches(threads > 1 ? kMostWait + 2 : 1);
  double squares = 0;
  if (anew) newton.squares_of_links = 0;
  try {
    std::optional<TaskQueue> queue;
    if (threads > 1) queue.emplace(kMostWait);
    for (std::size_t first = 0; first < at.size(); first += kStretch) {
      ArrowEquations& stretch = stretches[first / kStretch % stretches.size()];
      const std::size_t last = std::min(first + kStretch, at.size());
      for (std::size_t i = first; anew && i < std::min(last, at.size() - 1); ++i) {
        newton.squares_of_links += terms.tie(i, at[i], at[i + 1], out.links());
      }
      write_down(terms, weights, at, first, last, stretch);
      squares += stretch.squares();
      if (!std::isfinite(squares + newton.squares_of_links)) return squares + newton.squares_of_links;
      if (queue) {
        queue->add([&out, &stretch] { out.append(stretch); });
      } else {
        out.append(stretch);
      }
    }
    if (queue) queue->finish();
    out.finish();
  } catch (const std::domain_error& e) {
    throw DataError("batch", e.what());
  }
  return 0.5 * (squares + newton.squares_of_links);
}

Refined refine(BatchTerms& terms, const std::vector<double>& weights, BatchStates& states, Newton& newton,
               WhereNot unsettled, std::size_t threads) {
  constexpr int kMost = 20, kMostRises = 3;
  const double enough = by_nodes(kSettled, states.size());
  newton.at = states;
  double first = 0, before = 0, fell = 0, least = std::numeric_limits<double>::infinity();
  int k = 0;
  for (int rises = 0; k < kMost; ++k) {
    const double cost = eliminate(terms, weights, newton, true, threads);
    if (k == 0) first = cost;
    if (cost < least) {
      least = cost;
      if (k > 0 && unsettled == WhereNot::kLowest) states = newton.at;
    }
    if (!std::isfinite(cost) || (k > 0 && cost > before && ++rises == kMostRises)) break;
    before = cost;
    const double fall = cost - 0.5 * newton.equations.least();
    // From the second step on the fall shrinks as that of Newton's steps does, whose roots are squared.
    const bool settled = fall < enough || (k > 0 && fall < fell && fall * (fall / fell) * (fall / fell) < enough);
    take_step(terms.layout(), newton, settled ? states : newton.at, threads);
    newton.fall = fall;
    if (settled) return {cost - fall, first - cost + fall, k + 1, true};
    terms.linearise(newton.at, threads);
    fell = fall;
  }
  newton.at = states;
  newton.step = {Blocks(states.size(), terms.layout().node.size(), 1),
                 Eigen::VectorXd::Zero(terms.layout().constant.size())};
  terms.linearise(states, threads);
  return {least, first - least, k, false};
}

Refined reweigh(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states, Newton& newton,
                std::size_t threads) {
  const double cost = eliminate(terms, weights, newton, false, threads), least = 0.5 * newton.equations.least();
  const bool near = cost - least < newton.fall + by_nodes(kSettled, states.size());
  if (near) take_step(terms.layout(), newton, states, threads);
  return {least, cost - least, 1, near};
}

std::vector<double> squares_of(const BatchTerms& terms, const Newton& newton, std::size_t threads) {
  const std::vector<ChainFix>& fixes = terms.chain().fixes;
  std::vector<double> out(fixes.size());
  for_each_stretch(fixes.size(), kPerTask, threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) out[i] = terms.fixes().square(i, fixes[i].node, newton.step);
  });
  return out;
}

}  // namespace piste
