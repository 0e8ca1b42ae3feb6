#include "weights.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace piste {
namespace {

// Factor of μ from one solve to the next. Yang et al. take 1.4 where nothing is known at first. A filtered run is near
// its solution, and every step is a solve.
constexpr double kGraduation = 2;

// The weight of Geman and McClure's loss, of which the bound is widened by μ (Yang et al. 2020, equation 12). With μ =
// 1 it is Barron's (2019) with α = −2. Few fixes off leave the weights of the others near one, as the samples of the
// IMU, which have none, require: the surrogate of truncated squares would begin with all fixes near zero.
double softened(double square, double bound, double mu) {
  const double part = 1 + square / (mu * bound);
  return 1 / (part * part);
}

}  // namespace

BatchWeights::BatchWeights(BatchLoss loss, std::vector<double> bound, std::vector<double> weights, bool graduate)
    : loss_(loss), bound_(std::move(bound)), weights_(std::move(weights)), begun_(!graduate) {}

bool BatchWeights::update(const std::vector<double>& squares) {
  constexpr double kEnough = 1e-3;
  if (loss_ == BatchLoss::kSquared) return false;
  if (!std::exchange(begun_, true)) {
    double worst = 0;  // of those that count
    for (std::size_t i = 0; i < squares.size(); ++i) {
      if (weights_[i] > 0.5) worst = std::max(worst, squares[i] / bound_[i]);
    }
    if (worst > 1) mu_ = 2 * worst;  // so convex that the worst of them counts
  }
  const std::vector<double> before = weights_;
  const bool hard = loss_ == BatchLoss::kTruncated && mu_ <= 1;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    weights_[i] = hard ? (squares[i] < bound_[i] ? 1 : 0) : softened(squares[i], bound_[i], std::max(mu_, 1.0));
  }
  const bool last = mu_ <= 1;
  mu_ /= kGraduation;
  return !last || !std::equal(before.begin(), before.end(), weights_.begin(),
                              [](double a, double b) { return std::abs(a - b) < kEnough; });
}

}  // namespace piste
