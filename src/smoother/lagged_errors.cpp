#include "smoother/lagged_errors.h"

#include <algorithm>
#include <stdexcept>

#include "smoother/backward_pass.h"

namespace piste {
namespace {

// Goes back over the rows of the numbers. `take(index, a · P_smoothed a, covariances with all later ones)`.
template <class Take>
void go_back(const FilterRun& run, const std::vector<ErrorNumber>& numbers, bool trace, const Take& take) {
  if (!run.history) throw std::logic_error("covariances of epochs need a run with its history");
  BackwardPass backward(run);
  struct Visit {
    BackwardPass& backward;
    const std::vector<ErrorNumber>& numbers;
    bool trace;
    const Take& take;
    bool asked(std::size_t row) const {
      const auto at = std::lower_bound(numbers.begin(), numbers.end(), row,
                                       [](const ErrorNumber& n, std::size_t r) { return n.row < r; });
      return at != numbers.end() && at->row == row;
    }
    BackwardPass::Want wants(std::size_t row) const {
      return asked(row) ? BackwardPass::Want::kWhole : BackwardPass::Want::kNothing;
    }
    void seen(std::size_t row, double, const SmoothedParts&, const FilterState* whole) {
      if (!asked(row)) return;
      const Covariance smoothed = backward.smooth(*whole).P;
      auto i =
          static_cast<std::size_t>(std::upper_bound(numbers.begin(), numbers.end(), row,
                                                    [](std::size_t r, const ErrorNumber& n) { return r < n.row; }) -
                                   numbers.begin());
      for (; i > 0 && numbers[i - 1].row == row; --i) {
        Eigen::VectorXd a = Eigen::VectorXd::Zero(smoothed.rows());
        a.head<9>() = numbers[i - 1].a;
        take(i - 1, a.dot(smoothed * a),
             [&] { return Eigen::VectorXd(backward.lagged_numbers(whole->P).transpose() * a); });
        if (trace) backward.trace(*whole, a);
      }
    }
    void start(const FilterState&) {}
  };
  backward.run(numbers.empty() ? run.epochs : numbers.front().row, {}, Visit{backward, numbers, trace, take});
}

}  // namespace

Eigen::MatrixXd lagged_covariances(const FilterRun& run, const std::vector<ErrorNumber>& numbers,
                                   const std::vector<std::size_t>& early) {
  const auto count = static_cast<Eigen::Index>(numbers.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(early.size()), count);
  go_back(run, numbers, true, [&](std::size_t i, double variance, const auto& later) {
    const auto at = std::lower_bound(early.begin(), early.end(), i);
    if (at == early.end() || *at != i) return;
    const Eigen::Index row = at - early.begin();
    const Eigen::VectorXd covariances = i + 1 < numbers.size() ? later() : Eigen::VectorXd();
    C(row, static_cast<Eigen::Index>(i)) = variance;
    // Traced from the last number on.
    for (Eigen::Index k = 0; k < covariances.size(); ++k) C(row, count - 1 - k) = covariances(k);
  });
  return C;
}

std::vector<double> variances(const FilterRun& run, const std::vector<ErrorNumber>& numbers) {
  std::vector<double> out(numbers.size(), 0);
  go_back(run, numbers, false, [&](std::size_t i, double variance, const auto&) { out[i] = variance; });
  return out;
}

}  // namespace piste
