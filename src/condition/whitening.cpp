#include "whitening.h"

#include <cmath>

#include "math/linear_algebra.h"
#include "piste/math/statistics.h"

namespace piste {

double Whitening::gain() const {
  double sum = 0;
  for (const double tap : taps) sum += tap;
  return sum;
}

LinearFilter Whitening::filter(std::size_t stride) const {
  return [taps = taps, stride](std::span<const Vector3d> signal) {
    std::vector<Vector3d> out(signal.size());
    for (std::size_t k = 0; k < signal.size(); ++k) {
      Vector3d sum = Vector3d::Zero();
      for (std::size_t i = 0; i < taps.size(); ++i) sum += taps[i] * signal[k >= i * stride ? k - i * stride : 0];
      out[k] = sum;
    }
    return out;
  };
}

Whitening autoregression(const std::vector<Left>& left, double sigma) {
  constexpr double kOutlier = 5;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(kWhiteningOrder, kWhiteningOrder);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(kWhiteningOrder);
  int rows = 0;
  for (std::size_t k = kWhiteningOrder; k < left.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Matrix<double, kWhiteningOrder, 1> past;
      bool whole = left[k].axes >> axis & 1 && std::abs(left[k].value(axis)) < kOutlier * sigma;
      for (int i = 0; i < kWhiteningOrder; ++i) {
        const Left& before = left[k - static_cast<std::size_t>(i) - 1];
        past(i) = before.value(axis);
        whole = whole && before.axes >> axis & 1 && std::abs(past(i)) < kOutlier * sigma;
      }
      if (!whole) continue;
      A += past * past.transpose();
      b += past * left[k].value(axis);
      ++rows;
    }
  }
  Whitening w;
  if (rows < 20 * kWhiteningOrder) return w;
  const Eigen::VectorXd a = solve_symmetric(A, b);
  for (const double tap : a) w.taps.push_back(-tap);
  return w;
}

FilteredPair whitened(const FilteredPair& pair, const Whitening& gyro, const Whitening& accel) {
  const double reach = kWhiteningOrder * static_cast<double>(pair.stride) * pair.body.step;
  TriadFilters filters;
  filters.gyro = gyro.filter(pair.stride);
  filters.accel = accel.filter(pair.stride);
  filters.before = reach;
  return {pair.body.filtered(filters),
          pair.reference.filtered(filters),
          gyro.gain(),
          accel.gain(),
          pair.margin + reach,
          pair.stride};
}

double robust_sigma(const std::vector<Left>& left) {
  std::vector<double> sizes;
  for (const Left& l : left) {
    for (int axis = 0; axis < 3; ++axis) {
      if (l.axes >> axis & 1) sizes.push_back(std::abs(l.value(axis)));
    }
  }
  if (sizes.empty()) return 0;
  const double limit = 4 * kSigmaOverMedian * median(sizes);
  double square = 0, count = 0;
  for (const double size : sizes) {
    if (size > limit) continue;
    square += size * size;
    count += 1;
  }
  return std::sqrt(square / count);
}

}  // namespace piste
