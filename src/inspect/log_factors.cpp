#include "log_factors.h"

#include <algorithm>
#include <cmath>

#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kUnitTolerance = 1.35;  // of a factor

LogFactors rough_factors(const LogMatch& m) {
  constexpr double kFarOff = 3;
  LogFactors factors;
  if (!m.clock || m.turn_ratio == 0) return factors;
  const double other = m.increments ? m.interval : 1 / m.interval;
  for (const double accel : {kStandardGravity, 1 / kStandardGravity, other}) {
    if (rather_factor(kStandardGravity / m.force, accel)) factors.accel = accel;
  }
  const auto distance = [&](double gyro) { return std::abs(std::log(m.turn_ratio * gyro)); };
  if (factors.accel == other && distance(other) < std::log(kFarOff)) {
    factors.gyro = other;
    return factors;
  }
  for (const double gyro : {kDegreesPerRadian, kDegree}) {
    if (distance(gyro) < std::min(distance(1), std::log(kFarOff))) factors.gyro = gyro;
  }
  return factors;
}

}  // namespace

bool near_factor(double factor, double expected) {
  return std::abs(std::log(std::abs(factor / expected))) < std::log(kUnitTolerance);
}

bool rather_factor(double factor, double expected) {
  return near_factor(factor, expected) && std::abs(std::log(factor / expected)) < std::abs(std::log(factor));
}

LogFactors log_factors(const LogMatch& m) {
  return m.motion ? LogFactors{m.motion->gyro_factor, m.motion->accel_factor} : rough_factors(m);
}

}  // namespace piste
