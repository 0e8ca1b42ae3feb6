#include "batch_normal.h"

#include <cmath>
#include <utility>

namespace piste {
namespace {

struct Solved {
  ArrowMatrix covariance;
  ArrowVector step;
};

Solved solved(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states) {
  const BatchLayout& layout = terms.layout();
  const Chain& chain = terms.chain();
  ArrowMatrix A(states.size(), layout.node.size(), layout.constant.size());
  ArrowVector b{{states.size(), Eigen::VectorXd::Zero(layout.node.size())},
                Eigen::VectorXd::Zero(layout.constant.size())};
  const auto add = [&](std::size_t node, const BatchTerm& t, double weight) {
    A.nodes[node].noalias() += weight * t.by_first.transpose() * t.by_first;
    A.sides[node].noalias() += weight * t.by_first.transpose() * t.by_constant;
    A.corner.noalias() += weight * t.by_constant.transpose() * t.by_constant;
    b.nodes[node].noalias() -= weight * t.by_first.transpose() * t.residual;
    b.border.noalias() -= weight * t.by_constant.transpose() * t.residual;
  };
  add(0, terms.prior(states.front()), 1);
  std::vector<ChainLink> links;
  links.reserve(chain.intervals.size());
  for (std::size_t i = 0; i < chain.intervals.size(); ++i) links.push_back(terms.link(i, states[i], states[i + 1]));
  for (std::size_t i = 0; i < chain.fixes.size(); ++i) {
    if (weights[i] > 0) add(chain.fixes[i].node, terms.fix(i, states[chain.fixes[i].node]), weights[i]);
  }
  invert_selected(A, b, links);
  return {std::move(A), std::move(b)};
}

double objective(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states) {
  const Chain& chain = terms.chain();
  double sum = terms.prior(states.front()).residual.squaredNorm();
  for (std::size_t i = 0; i < chain.intervals.size(); ++i) {
    sum += terms.interval(i, states[i], states[i + 1]).residual.squaredNorm();
  }
  for (std::size_t i = 0; i < chain.fixes.size(); ++i) {
    if (weights[i] > 0) sum += weights[i] * terms.fix(i, states[chain.fixes[i].node]).residual.squaredNorm();
  }
  return 0.5 * sum;
}

}  // namespace

ArrowMatrix covariance_of(const BatchTerms& terms, const std::vector<double>& weights, const BatchStates& states) {
  return solved(terms, weights, states).covariance;
}

double refine(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states) {
  // A step that changes it by less does not move the solution by a hundredth of a sigma of all unknowns together.
  constexpr double kNothing = 1e-5;
  constexpr int kMost = 20, kMostRises = 3;
  const BatchLayout& layout = terms.layout();
  BatchStates x = states;
  double cost = objective(terms, weights, x), least = cost;
  for (int k = 0, rises = 0; k < kMost && rises < kMostRises; ++k) {
    const ArrowVector step = solved(terms, weights, x).step;
    const FullError constants = layout.constant.expand(step.border.data());
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = boxplus(x[i], layout.node.expand(step.nodes[i].data()) + constants);
    const double now = objective(terms, weights, x), change = now - cost;
    rises += now < cost ? 0 : 1;
    cost = now;
    if (cost < least) {
      least = cost;
      states = x;
    }
    if (!(std::abs(change) > kNothing)) break;
  }
  return least;
}

}  // namespace piste
