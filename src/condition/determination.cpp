#include "determination.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "math/linear_algebra.h"
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

constexpr std::array kScales{std::pair{Layout::kGyroScale, &ImuSensor::gyro},
                             std::pair{Layout::kAccelScale, &ImuSensor::accel}};

}  // namespace

AlignmentInverse inverted(const AlignmentInformation& information, const AlignmentInformation& apparent,
                          const AlignmentInformation& variance, const ImuSensor& sensor) {
  // In units of the limits, eigenvalues of different parameters can be compared. A direction without information gets a
  // sigma of a hundred limits. So does one whose information is mostly apparent: the size of that part follows from
  // sensor files, which are not exact.
  constexpr double kNothing = 1e-6, kReal = 0.2, kUnknown = 1e4;
  Vector20 unit = Vector20::Ones();
  for (const Limit& limit : kLimits) unit.segment(limit.first, limit.count).setConstant(limit.sigma);
  for (const auto& [block, triad] : kScales) {
    if (const double sigma = (sensor.*triad).scale; sigma > 0) unit.segment<3>(block).setConstant(sigma);
  }
  const AlignmentInformation all = unit.asDiagonal() * information * unit.asDiagonal(),
                             real = all - unit.asDiagonal() * apparent * unit.asDiagonal();
  const Eigensystem eigen = eigensystem(real);
  const AlignmentInformation V = eigen.vectors, turned = V.transpose() * all * V,
                             more = V.transpose() * unit.asDiagonal() * variance * unit.asDiagonal() * V;
  Vector20 inverse = Vector20::Zero(), useful = inverse, unknown = inverse;
  for (int i = 0; i < Layout::kSize; ++i) {
    if (eigen.values(i) > std::max(kNothing, kReal * turned(i, i))) {
      inverse(i) = 1 / eigen.values(i);
      if (eigen.values(i) > 1) useful(i) = inverse(i);
    } else {
      unknown(i) = kUnknown;
    }
  }
  const auto in_units = [&](const AlignmentInformation& P) -> AlignmentInformation {
    const AlignmentInformation Q = unit.asDiagonal() * V * P * V.transpose() * unit.asDiagonal();
    return 0.5 * (Q + Q.transpose());
  };
  AlignmentInformation P = inverse.asDiagonal() * (turned + more) * inverse.asDiagonal();
  P.diagonal() += unknown;
  return {.known = in_units(useful.asDiagonal()), .covariance = in_units(P)};
}

void determine(Alignment& alignment, const AlignmentInformation& covariance, const ImuSensor& sensor) {
  AlignmentInformation& P = alignment.covariance;
  P = covariance;

  const auto cut = [&P](int at, double variance) {
    P.row(at).setZero();
    P.col(at).setZero();
    P(at, at) = variance;
  };
  for (const auto& [block, triad] : kScales) {
    for (int i = 0; i < 3 && (sensor.*triad).scale == 0; ++i) cut(block + i, 0);  // known to have none
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
