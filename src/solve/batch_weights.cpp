#include "batch_weights.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace piste {
namespace {

// Factor of μ from one solve to the next. Yang et al. take 1.4 where nothing is known at first. A filtered run is near
// its solution, and every step is a solve.
constexpr double kGraduation = 2;
constexpr double kTruncated = 1e3;  // μ at which only fixes within a thousandth of the bound are in between

// The weight of Yang et al. (2020), equation 14.
double graduated(double square, double bound, double mu) {
  if (square <= mu / (mu + 1) * bound) return 1;
  if (square >= (mu + 1) / mu * bound) return 0;
  return std::sqrt(bound / square * mu * (mu + 1)) - mu;
}

// Geman and McClure's: Barron (2019) with α = −2, whose weight at the bound is a quarter.
double of_barron(double square, double bound) {
  const double part = 1 + square / bound;
  return 1 / (part * part);
}

}  // namespace

BatchWeights::BatchWeights(BatchLoss loss, std::vector<double> bound, std::vector<double> weights)
    : loss_(loss), bound_(std::move(bound)), weights_(std::move(weights)) {}

bool BatchWeights::update(const std::vector<double>& squares) {
  constexpr double kEnough = 1e-3;
  if (loss_ == BatchLoss::kSquared) return false;
  const std::vector<double> before = weights_;
  if (loss_ == BatchLoss::kBarron) {
    for (std::size_t i = 0; i < squares.size(); ++i) weights_[i] = of_barron(squares[i], bound_[i]);
  } else {
    truncate(squares);
  }
  return !std::equal(before.begin(), before.end(), weights_.begin(),
                     [](double a, double b) { return std::abs(a - b) < kEnough; });
}

// One step of the graduation; the last of them leaves no weight between nothing and all.
void BatchWeights::truncate(const std::vector<double>& squares) {
  if (mu_ == 0) {
    double worst = 0;  // of those that count
    for (std::size_t i = 0; i < squares.size(); ++i) {
      if (weights_[i] > 0.5) worst = std::max(worst, squares[i] / bound_[i]);
    }
    // So convex that the worst of them is no more than half left out (equation 19).
    mu_ = worst > 1 ? std::min(1 / (2 * worst - 1), kTruncated) : kTruncated;
  }
  bool between = false;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    weights_[i] = graduated(squares[i], bound_[i], mu_);
    if (mu_ >= kTruncated) weights_[i] = std::round(weights_[i]);
    between = between || (weights_[i] > 0 && weights_[i] < 1);
  }
  mu_ = between ? std::min(mu_ * kGraduation, kTruncated) : kTruncated;
}

}  // namespace piste
