// The elimination of a chain with a border, against Ceres on the same problem.

#include "math/arrow_matrix.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <utility>

#include "support/random.h"

namespace piste {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A residual Σ J_i x_i + r of one, two or three blocks.
class Linear final : public ceres::CostFunction {
 public:
  Linear(std::vector<MatrixXd> J, VectorXd r) : J_(std::move(J)), r_(std::move(r)) {
    set_num_residuals(static_cast<int>(r_.size()));
    for (const MatrixXd& j : J_) mutable_parameter_block_sizes()->push_back(static_cast<int>(j.cols()));
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    VectorXd sum = r_;
    for (std::size_t i = 0; i < J_.size(); ++i) {
      sum += J_[i] * Eigen::Map<const VectorXd>(x[i], J_[i].cols());
      if (jacobians && jacobians[i]) Eigen::Map<RowMajor>(jacobians[i], J_[i].rows(), J_[i].cols()) = J_[i];
    }
    Eigen::Map<VectorXd>(residuals, r_.size()) = sum;
    return true;
  }

 private:
  std::vector<MatrixXd> J_;
  VectorXd r_;
};

TEST(ArrowMatrix, SolutionAndCovarianceAreThoseOfCeres) {
  constexpr int kNodes = 7, kNode = 4, kBorder = 3, kRows = 2, kFull = 2;
  test::Random random(5);
  std::vector<VectorXd> x(kNodes, VectorXd::Zero(kNode));
  VectorXd border = VectorXd::Zero(kBorder);
  ceres::Problem problem;
  ArrowEquations equations(kNodes, kNode, kBorder);
  const auto measure = [&](std::size_t node, int rows) {
    const MatrixXd J = random.matrix(rows, kNode), K = random.matrix(rows, kBorder);
    const VectorXd r = random.matrix(rows, 1);
    problem.AddResidualBlock(new Linear({J, K}, r), nullptr, x[node].data(), border.data());
    equations.add(node, J, K, r);
  };
  measure(0, kNode + kBorder + 2);
  ChainLinks chain(kNodes - 1, kNode, kBorder);
  for (std::size_t i = 0; i < kNodes; ++i) {
    if (i != 3) measure(i, kRows);  // one that nothing measures
    if (i + 1 == kNodes) break;
    MatrixXd F = random.matrix(kNode, kNode);
    F.bottomRows(kNode - kFull) = F.diagonal().asDiagonal().toDenseMatrix().bottomRows(kNode - kFull).eval();
    const MatrixXd B = random.matrix(kNode, kBorder), noise = random.covariance(kNode);
    const VectorXd c = random.matrix(kNode, 1);
    const MatrixXd W = Eigen::LLT<MatrixXd>(noise).matrixL().solve(MatrixXd::Identity(kNode, kNode));
    problem.AddResidualBlock(new Linear({W, -W * F, -W * B}, -W * c), nullptr, x[i + 1].data(), x[i].data(),
                             border.data());
    chain.F[i] = F;
    chain.B_transposed[i] << B.transpose(), c.transpose();
    chain.noise[i] = noise;
  }
  const ArrowElimination eliminated(equations, chain, kFull);
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 200;
  options.initial_trust_region_radius = 1e16;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  const ArrowVector solution = eliminated.solution();
  for (std::size_t i = 0; i < kNodes; ++i) EXPECT_TRUE(solution.nodes[i].isApprox(x[i], 1e-9)) << i;
  EXPECT_TRUE(solution.border.isApprox(border, 1e-9));
  EXPECT_NEAR(summary.final_cost, 0.5 * eliminated.least(), 1e-9 * summary.initial_cost);

  ceres::Covariance covariance{{}};
  std::vector<std::pair<const double*, const double*>> blocks{{border.data(), border.data()}};
  for (std::size_t i = 0; i < kNodes; ++i) {
    blocks.emplace_back(x[i].data(), x[i].data());
    blocks.emplace_back(x[i].data(), border.data());
    if (i + 1 < kNodes) blocks.emplace_back(x[i].data(), x[i + 1].data());
  }
  ASSERT_TRUE(covariance.Compute(blocks, &problem));
  const auto of_ceres = [&](const VectorXd& a, const VectorXd& c) {
    RowMajor out(a.size(), c.size());
    covariance.GetCovarianceBlock(a.data(), c.data(), out.data());
    return out;
  };
  const ArrowMatrix P = eliminated.covariance();
  EXPECT_TRUE(P.corner.isApprox(of_ceres(border, border), 1e-9));
  for (std::size_t i = 0; i < kNodes; ++i) {
    EXPECT_TRUE(P.nodes[i].isApprox(of_ceres(x[i], x[i]), 1e-9)) << i;
    EXPECT_TRUE(P.sides[i].isApprox(of_ceres(x[i], border), 1e-9)) << i;
    if (i + 1 < kNodes) {
      EXPECT_TRUE(P.links[i].isApprox(of_ceres(x[i], x[i + 1]), 1e-9)) << i;
    }
  }
}

}  // namespace
}  // namespace piste
