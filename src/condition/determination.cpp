#include "determination.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "piste/math/linear_algebra.h"
#include "piste/math/units.h"

namespace piste {
namespace {

using Layout = AlignmentLayout;
using Vector20 = Eigen::Matrix<double, Layout::kSize, 1>;

struct Limit {
  int first, count;
  double sigma;  // [s], ratio, [rad], [m], [rad/s], [m/s²]
  const char* name;
};

constexpr std::array kLimits{
    Limit{Layout::kClockOffset, 1, 5e-3, "clock offset"},    Limit{Layout::kClockDrift, 1, 200e-6, "clock drift"},
    Limit{Layout::kBoresight, 3, kDegree, "boresight"},      Limit{Layout::kLeverArm, 3, 0.05, "lever arm"},
    Limit{Layout::kGyroBias, 3, 0.5 * kDegree, "gyro bias"}, Limit{Layout::kAccelBias, 3, 0.2, "accelerometer bias"}};

}  // namespace

void determine(Alignment& alignment, AlignmentInformation information, double apparent, const ImuSensor& sensor) {
  information.diagonal().segment<3>(Layout::kBoresight).array() -= apparent;
  // In units of the limits, eigenvalues of different parameters can be compared. A direction without information gets a
  // sigma of a thousand limits.
  constexpr double kNothing = 1e-6;
  Vector20 unit = Vector20::Ones();
  for (const Limit& limit : kLimits) unit.segment(limit.first, limit.count).setConstant(limit.sigma);
  const std::array scales{std::pair{Layout::kGyroScale, sensor.gyro.scale},
                          std::pair{Layout::kAccelScale, sensor.accel.scale}};
  for (const auto& [block, sigma] : scales) {
    if (sigma > 0) unit.segment<3>(block).setConstant(sigma);
  }
  const AlignmentInformation scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const Eigensystem eigen = eigensystem(scaled);
  const Vector20 inverse = eigen.values.cwiseMax(kNothing).cwiseInverse();
  AlignmentInformation& P = alignment.covariance;
  P = unit.asDiagonal() * eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose() * unit.asDiagonal();
  P = (0.5 * (P + P.transpose())).eval();

  const auto cut = [&P](int at, double variance) {
    P.row(at).setZero();
    P.col(at).setZero();
    P(at, at) = variance;
  };
  for (const auto& [block, sigma] : scales) {
    for (int i = 0; i < 3 && sigma == 0; ++i) cut(block + i, 0);  // known to have none
  }
  for (const Limit& limit : kLimits) {
    for (int i = 0; i < limit.count; ++i) {
      const int at = limit.first + i;
      if (std::sqrt(P(at, at)) <= limit.sigma) continue;
      constexpr std::array kAxes{" x", " y", " z"};
      alignment.undetermined.push_back(std::string(limit.name) +
                                       (limit.count == 3 ? kAxes[static_cast<std::size_t>(i)] : ""));
      cut(at, std::numeric_limits<double>::infinity());
    }
  }
}

}  // namespace piste
