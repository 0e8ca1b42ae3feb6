#pragma once
/// How far two solutions of one run are apart, in sigmas.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "piste/core/solution.h"

namespace piste::test {

/// What two solutions differ by at most: values in sigmas, and sigmas by their ratio.
struct Apart {
  double value = 0, sigma = 0;

  void add(const Eigen::Ref<const Eigen::VectorXd>& difference, const Eigen::Ref<const Eigen::VectorXd>& is,
           const Eigen::Ref<const Eigen::VectorXd>& wanted) {
    for (Eigen::Index i = 0; i < wanted.size(); ++i) {
      if (wanted(i) == 0) continue;  // not estimated
      value = std::max(value, std::abs(difference(i)) / wanted(i));
      sigma = std::max(sigma, std::abs(is(i) / wanted(i) - 1));
    }
  }
};

/// Turns a row of a transformed run back into that of the run itself.
using TurnBack = std::function<void(Navigation&, Estimate&)>;

/// `far` against `near`, row by row.
inline Apart apart(
    const Solution& far, const Solution& near, const TurnBack& back = [](Navigation&, Estimate&) {}) {
  Apart a;
  EXPECT_EQ(far.size(), near.size());
  for (std::size_t i = 0; i < std::min(far.size(), near.size()); ++i) {
    Navigation x = far.navigation(i);
    Estimate estimate = far.estimate(i);
    back(x, estimate);
    const Navigation y = near.navigation(i);
    const Sigmas is = far.sigmas(i), wanted = near.sigmas(i);
    const World place(y.position);
    const Vector3d turn =
        (x.euler - y.euler).unaryExpr([](double angle) { return std::remainder(angle, 2 * std::numbers::pi); });
    a.add(place.from_geodetic(x.position), is.position, wanted.position);
    a.add(x.velocity - y.velocity, is.velocity, wanted.velocity);
    a.add(turn, is.euler, wanted.euler);
    const FullError difference = boxminus(estimate, near.estimate(i));  // of the blocks beyond navigation
    a.add(difference, is.blocks, wanted.blocks);
  }
  return a;
}

}  // namespace piste::test
