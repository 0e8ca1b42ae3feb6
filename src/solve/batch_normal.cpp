#include "batch_normal.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "piste/core/error.h"

namespace piste {
namespace {

// The objective about the states, to second order.
struct Quadratic {
  double of_links = 0;  // the sum of squares that is theirs
  ArrowSystem system;

  double cost() const { return 0.5 * (system.equations.squares() + of_links); }
};

// `room`: memory for it.
Quadratic quadratic(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states,
                    std::optional<ArrowElimination> room) {
  const Eigen::Index n = terms.layout().node.size(), g = terms.layout().constant.size();
  const Chain& chain = terms.chain();
  Quadratic out{.system = room ? std::move(*room).release() : ArrowSystem{}};
  out.system.reset(states.size(), n, g);
  auto& [equations, links, unused] = out.system;
  const BatchTerm prior = terms.prior(states.front());
  equations.add(0, prior.by_first, prior.by_constant, prior.residual);
  for (std::size_t i = 0; i < chain.intervals.size(); ++i) {
    out.of_links += terms.tie(i, states[i], states[i + 1], links);
  }
  ArrowRows rows(n, g);
  for (std::size_t i = 0; i < chain.fixes.size(); ++i) {
    if (weights[i] <= 0) continue;
    terms.fix(i, states[chain.fixes[i].node], std::sqrt(weights[i]), rows);
    equations.add(chain.fixes[i].node, rows);
  }
  return out;
}

ArrowElimination eliminated(Quadratic&& q) {
  try {
    return ArrowElimination(std::move(q.system));
  } catch (const std::domain_error& e) {
    throw DataError("batch", e.what());
  }
}

}  // namespace

ArrowElimination eliminated(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states) {
  return eliminated(quadratic(terms, weights, states, {}));
}

Refined refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states,
               std::optional<ArrowElimination> room) {
  // Half the square of seven sigmas of all unknowns together: what such a step leaves is of its second order, so much
  // less, and the next round, which lays the run out anew, takes it away. From the second step on the fall shrinks as
  // that of Newton's steps does, whose roots are squared.
  constexpr double kEnough = 25;
  constexpr int kMost = 20, kMostRises = 3;
  const BatchLayout& layout = terms.layout();
  BatchStates x = states;
  double first = 0, before = 0, fell = 0, least = std::numeric_limits<double>::infinity();
  int k = 0;
  for (int rises = 0; k < kMost; ++k) {
    Quadratic here = quadratic(terms, weights, x, std::move(room));
    const double cost = here.cost();
    if (k == 0) first = cost;
    if (cost < least) {
      least = cost;
      states = x;
    }
    if (!std::isfinite(cost) || (k > 0 && cost > before && ++rises == kMostRises)) break;
    before = cost;
    room = eliminated(std::move(here));
    const double fall = cost - 0.5 * room->least();
    const ArrowVector step = room->solution();
    const FullError constants = layout.constant.expand(step.border.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = boxplus(x[i], layout.node.expand(step.nodes[i].data()) + constants);
    }
    const bool shrinks = k > 0 && fall < fell && fall * (fall / fell) * (fall / fell) < kEnough;
    if (fall < kEnough || shrinks) {
      states = std::move(x);
      return {cost - fall, first - cost + fall, k + 1, std::move(room)};
    }
    fell = fall;
  }
  return {least, first - least, k, {}};
}

}  // namespace piste
