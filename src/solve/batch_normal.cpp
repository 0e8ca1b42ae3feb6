#include "batch_normal.h"

#include <cmath>
#include <limits>
#include <utility>

namespace piste {
namespace {

// The objective about the states, to second order.
struct Quadratic {
  double cost = 0, of_links = 0;  // `of_links`: the part of the cost that is theirs
  ArrowMatrix A;
  ArrowVector b;
  std::vector<ChainLink> links;
};

Quadratic quadratic(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states) {
  const BatchLayout& layout = terms.layout();
  const Chain& chain = terms.chain();
  Quadratic out{
      .A = ArrowMatrix(states.size(), layout.node.size(), layout.constant.size()),
      .b = {{states.size(), Eigen::VectorXd::Zero(layout.node.size())}, Eigen::VectorXd::Zero(layout.constant.size())},
      .links = {}};
  double squares = 0, of_links = 0;
  const auto add = [&](std::size_t node, const BatchTerm& t, double weight) {
    squares += weight * t.residual.squaredNorm();
    // A few rows: coefficient by coefficient is faster than by blocks.
    out.A.nodes[node] += weight * t.by_first.transpose().lazyProduct(t.by_first);
    out.A.sides[node] += weight * t.by_first.transpose().lazyProduct(t.by_constant);
    out.A.corner += weight * t.by_constant.transpose().lazyProduct(t.by_constant);
    out.b.nodes[node].noalias() -= weight * t.by_first.transpose() * t.residual;
    out.b.border.noalias() -= weight * t.by_constant.transpose() * t.residual;
  };
  add(0, terms.prior(states.front()), 1);
  out.links.reserve(chain.intervals.size());
  for (std::size_t i = 0; i < chain.intervals.size(); ++i) {
    BatchTerms::Tie tie = terms.tie(i, states[i], states[i + 1]);
    out.links.push_back(std::move(tie.link));
    of_links += tie.square;
  }
  for (std::size_t i = 0; i < chain.fixes.size(); ++i) {
    if (weights[i] > 0) add(chain.fixes[i].node, terms.fix(i, states[chain.fixes[i].node]), weights[i]);
  }
  out.of_links = 0.5 * of_links;
  out.cost = 0.5 * squares + out.of_links;
  return out;
}

ArrowElimination eliminated(Quadratic&& q) { return {std::move(q.A), std::move(q.b), std::move(q.links)}; }

}  // namespace

ArrowElimination eliminated(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states) {
  return eliminated(quadratic(terms, weights, states));
}

Refined refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states) {
  // The last step moves the solution by less than a twentieth of a sigma of all unknowns together, and what is left is
  // of its second order.
  constexpr double kLast = 1e-3;
  constexpr int kMost = 20, kMostRises = 3;
  const BatchLayout& layout = terms.layout();
  BatchStates x = states;
  double first = 0, before = 0, least = std::numeric_limits<double>::infinity();
  int k = 0;
  for (int rises = 0; k < kMost; ++k) {
    Quadratic here = quadratic(terms, weights, x);
    const double cost = here.cost, of_links = here.of_links;
    if (k == 0) first = cost;
    if (cost < least) {
      least = cost;
      states = x;
    }
    if (!std::isfinite(cost) || (k > 0 && cost > before && ++rises == kMostRises)) break;
    before = cost;
    ArrowElimination equations = eliminated(std::move(here));
    const double fall = of_links + equations.depth();
    const ArrowVector step = equations.solution();
    const FullError constants = layout.constant.expand(step.border.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = boxplus(x[i], layout.node.expand(step.nodes[i].data()) + constants);
    }
    if (fall < kLast) {
      states = std::move(x);
      return {cost - fall, first - cost + fall, k + 1, std::move(equations)};
    }
  }
  return {least, first - least, k, {}};
}

}  // namespace piste
