#include "batch_normal.h"

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

// The objective about the states to second order, of the nodes from `first` to before `last` and the links from them.
// Returns the sum of squares of the links.
double write_down(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states,
                  std::size_t first, std::size_t last, ArrowRows& rows, ArrowStretch& out) {
  const Chain& chain = terms.chain();
  const std::size_t end_of_links = std::min(last, chain.intervals.size());
  out.reset(last - first, end_of_links - first, terms.layout().node.size(), terms.layout().constant.size());
  if (first == 0) {
    const BatchTerm prior = terms.prior(states.front());
    out.equations.add(0, prior.by_first, prior.by_constant, prior.residual);
  }
  double of_links = 0;
  for (std::size_t i = first; i < end_of_links; ++i) {
    of_links += terms.tie(i, states[i], states[i + 1], out.links, i - first);
  }
  const auto of_node = [&](std::size_t node) {
    const auto before = [node](const ChainFix& fix) { return fix.node < node; };
    return static_cast<std::size_t>(std::partition_point(chain.fixes.begin(), chain.fixes.end(), before) -
                                    chain.fixes.begin());
  };
  for (std::size_t i = of_node(first); i < chain.fixes.size() && chain.fixes[i].node < last; ++i) {
    if (weights[i] <= 0) continue;
    terms.fix(i, states[chain.fixes[i].node], std::sqrt(weights[i]), rows);
    out.equations.add(chain.fixes[i].node - first, rows);
  }
  return of_links;
}

}  // namespace

double eliminate(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states,
                 std::size_t threads, ArrowElimination& out) {
  const Eigen::Index n = terms.layout().node.size(), g = terms.layout().constant.size();
  out.begin(states.size(), n, g);
  ArrowRows rows(n, g);
  // One stretch is written down while others wait for another thread, which eliminates them in their order.
  constexpr std::size_t kMostWait = 4;
  std::vector<ArrowStretch> stretches(threads > 1 ? kMostWait + 2 : 1);
  double squares = 0;
  try {
    std::optional<TaskQueue> queue;
    if (threads > 1) queue.emplace(kMostWait);
    for (std::size_t first = 0; first < states.size(); first += kStretch) {
      ArrowStretch& stretch = stretches[first / kStretch % stretches.size()];
      const std::size_t last = std::min(first + kStretch, states.size());
      squares += write_down(terms, weights, states, first, last, rows, stretch);
      squares += stretch.equations.squares();
      if (!std::isfinite(squares)) return squares;
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
  return 0.5 * squares;
}

Refined refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states, Newton& newton,
               WhereNot unsettled, std::size_t threads) {
  // Half the square of seven sigmas of all unknowns of a thousand nodes together: what such a step leaves is of its
  // second order, so much less, and the next round, which lays the run out anew, takes it away. That order is made
  // where the step is, so that a longer run may move more in all. From the second step on the fall shrinks as that of
  // Newton's steps does, whose roots are squared.
  constexpr double kEnough = 25, kNodes = 1000;
  constexpr int kMost = 20, kMostRises = 3;
  const double enough = kEnough * std::max(1.0, static_cast<double>(states.size()) / kNodes);
  const BatchLayout& layout = terms.layout();
  ArrowElimination& here = newton.equations;
  BatchStates& x = newton.moved;
  x = states;
  double first = 0, before = 0, fell = 0, least = std::numeric_limits<double>::infinity();
  int k = 0;
  for (int rises = 0; k < kMost; ++k) {
    const double cost = eliminate(terms, weights, x, threads, here);
    if (k == 0) first = cost;
    if (cost < least) {
      least = cost;
      if (k > 0 && unsettled == WhereNot::kLowest) states = x;
    }
    if (!std::isfinite(cost) || (k > 0 && cost > before && ++rises == kMostRises)) break;
    before = cost;
    const double fall = cost - 0.5 * here.least();
    const ArrowVector step = here.solution();
    for_each_stretch(x.size(), kPerTask, threads, [&](std::size_t begin, std::size_t end) {
      ErrorVector error(layout.whole.size());
      layout.constant.put(step.border.data(), error);
      for (std::size_t i = begin; i < end; ++i) {
        layout.node.put(step.nodes[i].data(), error);
        x[i] = boxplus(x[i], layout.whole, error);
      }
    });
    const bool shrinks = k > 0 && fall < fell && fall * (fall / fell) * (fall / fell) < enough;
    if (fall < enough || shrinks) {
      std::swap(states, x);
      return {cost - fall, first - cost + fall, k + 1, true};
    }
    fell = fall;
  }
  return {least, first - least, k, false};
}

}  // namespace piste
