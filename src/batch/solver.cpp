#include "solver.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "math/solve_least_squares.h"
#include "piste/core/error.h"

namespace piste {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A part of the state as Ceres' manifold, with the boxplus of the whole project. Our Jacobians are by the error, so
// that of Plus is the identity, with zeros below for what a rotation has more than its tangent. Ceres uses the product
// of both alone.
class PartManifold final : public ceres::Manifold {
 public:
  explicit PartManifold(const BatchLayout::Part& part) : part_(part) {}
  int AmbientSize() const override { return part_.stored(); }
  int TangentSize() const override { return part_.size(); }
  bool Plus(const double* x, const double* delta, double* moved) const override {
    Estimate at;
    part_.load(x, at);
    part_.store(boxplus(at, part_.expand(delta)), moved);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<RowMatrix>(jacobian, AmbientSize(), TangentSize()).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* difference) const override {
    Estimate to, from;
    part_.load(y, to);
    part_.load(x, from);
    Eigen::Map<Eigen::VectorXd>(difference, part_.size()) = part_.select(boxminus(to, from));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<RowMatrix>(jacobian, TangentSize(), AmbientSize()).setIdentity();
    return true;
  }

 private:
  const BatchLayout::Part& part_;
};

// A term with its unknowns: one or two nodes, then the constants if there are any.
class TermCost final : public ceres::CostFunction {
 public:
  enum class Kind { kPrior, kInterval, kFix };
  TermCost(const BatchTerms& terms, Kind kind, std::size_t index, int rows, double weight)
      : terms_(terms), kind_(kind), index_(index), root_weight_(std::sqrt(weight)) {
    set_num_residuals(rows);
    const BatchLayout& layout = terms.layout();
    auto* sizes = mutable_parameter_block_sizes();
    sizes->push_back(layout.node.stored());
    if (kind == Kind::kInterval) sizes->push_back(layout.node.stored());
    if (layout.constant.size() > 0) sizes->push_back(layout.constant.stored());
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const BatchLayout& layout = terms_.layout();
    const int nodes = kind_ == Kind::kInterval ? 2 : 1;
    Estimate x[2];
    for (int i = 0; i < nodes; ++i) {
      layout.node.load(parameters[i], x[i]);
      if (layout.constant.size() > 0) layout.constant.load(parameters[nodes], x[i]);
    }
    const BatchTerm term = kind_ == Kind::kPrior      ? terms_.prior(x[0])
                           : kind_ == Kind::kInterval ? terms_.interval(index_, x[0], x[1])
                                                      : terms_.fix(index_, x[0]);
    Eigen::Map<Eigen::VectorXd>{residuals, num_residuals()} = root_weight_ * term.residual;
    if (jacobians == nullptr) return true;
    write(jacobians[0], term.by_first, layout.node);
    if (nodes == 2) write(jacobians[1], term.by_second, layout.node);
    if (layout.constant.size() > 0) write(jacobians[nodes], term.by_constant, layout.constant);
    return true;
  }

 private:
  void write(double* to, const Eigen::MatrixXd& from, const BatchLayout::Part& part) const {
    if (to == nullptr) return;
    Eigen::Map<RowMatrix> out(to, num_residuals(), part.stored());
    out.setZero();
    out.leftCols(part.size()) = root_weight_ * from;
  }

  const BatchTerms& terms_;
  Kind kind_;
  std::size_t index_;
  double root_weight_;
};

}  // namespace

BatchStep minimise(const BatchTerms& terms, const std::vector<double>& weights, BatchStates& states) {
  const BatchLayout& layout = terms.layout();
  const Chain& chain = terms.chain();
  std::vector<std::vector<double>> nodes(states.size(),
                                         std::vector<double>(static_cast<std::size_t>(layout.node.stored())));
  std::vector<double> constants(static_cast<std::size_t>(layout.constant.stored()));
  for (std::size_t i = 0; i < states.size(); ++i) layout.node.store(states[i], nodes[i].data());
  layout.constant.store(states.front(), constants.data());

  PartManifold of_node(layout.node), of_constants(layout.constant);
  ceres::Problem::Options owned;
  owned.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  owned.disable_all_safety_checks = true;  // thousands of blocks, all of this function's making
  ceres::Problem problem(owned);
  for (auto& node : nodes) problem.AddParameterBlock(node.data(), layout.node.stored(), &of_node);
  if (!constants.empty()) problem.AddParameterBlock(constants.data(), layout.constant.stored(), &of_constants);
  const auto add = [&](TermCost::Kind kind, std::size_t index, int rows, double weight, std::vector<double*> blocks) {
    if (!constants.empty()) blocks.push_back(constants.data());
    problem.AddResidualBlock(new TermCost(terms, kind, index, rows, weight), nullptr, blocks);  // the problem owns it
  };
  add(TermCost::Kind::kPrior, 0, layout.whole.size(), 1, {nodes.front().data()});
  for (std::size_t i = 0; i < chain.intervals.size(); ++i) {
    add(TermCost::Kind::kInterval, i, layout.node.size(), 1, {nodes[i].data(), nodes[i + 1].data()});
  }
  for (std::size_t i = 0; i < chain.fixes.size(); ++i) {
    if (weights[i] > 0)
      add(TermCost::Kind::kFix, i, terms.rows_of_fix(i), weights[i], {nodes[chain.fixes[i].node].data()});
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1e12;  // as Gauss and Newton, unless that does not go down
  options.max_trust_region_radius = 1e16;
  options.function_tolerance = 1e-6;  // refine() does the remainder
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  constexpr int kMost = 100;
  options.max_num_iterations = kMost;
  ceres::Solver::Summary summary;
  solve_least_squares(options, problem, summary);
  if (!summary.IsSolutionUsable() || !std::isfinite(summary.final_cost)) {
    throw DataError("batch", fmt::format("its equations cannot be solved ({}); check units, axes and time stamps of "
                                         "the logs",
                                         summary.message));
  }
  for (std::size_t i = 0; i < states.size(); ++i) {
    layout.node.load(nodes[i].data(), states[i]);
    if (!constants.empty()) layout.constant.load(constants.data(), states[i]);
  }
  return {summary.initial_cost, summary.final_cost, static_cast<int>(summary.iterations.size()) - 1};
}

}  // namespace piste
