#pragma once
/// Made-up ensembles of compared runs, with errors and innovations that agree with the claimed covariance, or do not.

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <string>

#include "piste/consistency/consistency.h"
#include "piste/sim/random.h"

namespace piste::test {

/// Parameters of the drawn errors, and of the claimed covariance.
struct Ensemble {
  int runs = 60;
  EpochGrid grid{.step = 1, .first = -10, .last = 60, .cruise = {5, 45}, .arrival = 50};
  double claimed = 1;       ///< claimed covariance relative to the true one; of the smoother half of both
  double claimed_rest = 1;  ///< likewise while at rest before the start
  double whiteness = 0;     ///< correlation of successive innovations
};

/// An error of all states together, correlated across blocks whose units differ by orders of magnitude. Errors of
/// successive epochs are independent, so a mean over epochs counts as one over as many runs more.
inline ComparedRun drawn_run(const Ensemble& ensemble, std::uint64_t seed) {
  constexpr std::array kBlocksEstimated{Block::kGyroBias, Block::kAccelBias, Block::kGyroScale, Block::kAccelScale};
  ComparedRun run;
  run.seed = seed;
  run.layout = StateLayout(kBlocksEstimated);
  const Eigen::Index n = run.layout.size();
  Eigen::VectorXd sigma(n);
  sigma << Eigen::Vector3d::Constant(0.5), Eigen::Vector3d::Constant(0.05), Eigen::Vector3d::Constant(0.01),
      Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(5e-3),
      Eigen::Vector3d::Constant(5e-3);
  // The correlation of two states is 0.5 to the power of their distance.
  Eigen::MatrixXd P(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) P(i, j) = sigma(i) * sigma(j) * std::pow(0.5, std::abs(i - j));
  }
  const Eigen::MatrixXd L = P.llt().matrixL();
  RandomStream errors(seed, "errors"), innovations(seed, "innovations");
  const auto sample = [&](int epoch, double part) {
    Eigen::VectorXd z(n);
    for (double& value : z) value = errors.normal();
    const double claim = ensemble.grid.time(epoch) < 0 ? ensemble.claimed_rest : ensemble.claimed;
    return ErrorSample{epoch, std::sqrt(part) * L * z, part * claim * P, part * P.diagonal()};
  };
  for (int epoch = ensemble.grid.first; epoch <= ensemble.grid.last; ++epoch) {
    run.filtered.push_back(sample(epoch, 1));
    run.smoothed.push_back(sample(epoch, 0.5));
  }
  run.sources = {"gnss[0].position", "attitude[0]", "rest.velocity"};
  const double r = ensemble.whiteness;
  Vector3d z = innovations.normal3();
  for (int i = 0; i <= 10 * 60; ++i) {
    z = r * z + std::sqrt(1 - r * r) * innovations.normal3();
    const Vector3d sigma_z(0.5, 0.7, 0.9);
    run.innovations.push_back({.time = 0.1 * i,
                               .source = 0,
                               .dof = 3,
                               .residual = z.cwiseProduct(sigma_z),
                               .sigma = sigma_z,
                               .nis = z.squaredNorm(),
                               .gate = 16.27,
                               .outcome = z.squaredNorm() > 16.27 ? Outcome::kRejected : Outcome::kUsed});
    const double one = innovations.normal();
    run.innovations.push_back({.time = 0.1 * i,
                               .source = 1,
                               .dof = 1,
                               .residual = {0.01 * one, 0, 0},
                               .sigma = {0.01, 0, 0},
                               .nis = one * one,
                               .gate = 0,
                               .outcome = Outcome::kUsed});
  }
  return run;
}

/// The sum over seeds 1 to `runs`.
inline Consistency added(const Ensemble& ensemble) {
  Consistency sums(ensemble.grid);
  for (int seed = 1; seed <= ensemble.runs; ++seed) sums.add(drawn_run(ensemble, static_cast<std::uint64_t>(seed)));
  return sums;
}

}  // namespace piste::test
