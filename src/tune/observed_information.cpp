#include <Eigen/Cholesky>
#include <vector>

#include "tune/noise_search.h"

namespace piste {

Eigen::MatrixXd observed_information(const NoiseSearch& search, const JudgedLog& log, const NoiseFound& found) {
  constexpr double kNearest = 0.05, kFarthest = 1;  // of logarithms
  const auto n = static_cast<Eigen::Index>(found.knobs.size());
  // As far as each number is unsure: a parabola is to fit there.
  const Eigen::VectorXd apart =
      found.information.diagonal().cwiseSqrt().cwiseInverse().cwiseMax(kNearest).cwiseMin(kFarthest);
  std::vector<NoiseModel> models;
  const auto add = [&](const Eigen::VectorXd& by) {
    models.push_back(moved(found.knobs, found.best.model, apart.cwiseProduct(by)));
  };
  add(Eigen::VectorXd::Zero(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd up = Eigen::VectorXd::Unit(n, i);
    add(up);
    add(-up);
    for (Eigen::Index j = 0; j < i; ++j) {
      add(up + Eigen::VectorXd::Unit(n, j));
      add(-up - Eigen::VectorXd::Unit(n, j));
    }
  }
  const std::vector<NoisePoint> points = search.filtered(log, models);
  std::size_t next = 1;
  const auto bend = [&] {  // of the parabola through the middle and two points on either side of it
    const double sum = points[next].value + points[next + 1].value;
    next += 2;
    return 2 * points.front().value - sum;
  };
  Eigen::MatrixXd information(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    information(i, i) = bend();
    for (Eigen::Index j = 0; j < i; ++j) information(i, j) = information(j, i) = bend();
  }
  for (Eigen::Index i = 0; i < n; ++i) {  // along both knobs at once it is that of each and twice the mixed one
    for (Eigen::Index j = 0; j < i; ++j) {
      const double mixed = (information(i, j) - information(i, i) - information(j, j)) / 2;
      information(i, j) = information(j, i) = mixed;
    }
  }
  information = apart.cwiseInverse().asDiagonal() * information * apart.cwiseInverse().asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> root(information);
  return information.allFinite() && root.info() == Eigen::Success ? information : found.information;
}

}  // namespace piste
