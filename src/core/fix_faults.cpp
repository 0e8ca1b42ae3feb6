#include "core/fix_faults.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "piste/math/units.h"

namespace piste {

std::string fault_of(const Geodetic& place) {
  constexpr double kPi = std::numbers::pi, kHighest = 1e6;
  if (!(std::abs(place.latitude) <= kPi / 2)) {
    return fmt::format("latitude {:.6f} deg is beyond 90 deg; are latitude and longitude exchanged?",
                       place.latitude / kDegree);
  }
  if (!(std::abs(place.longitude) <= 2 * kPi)) {
    return fmt::format("longitude {:.6f} deg is beyond 360 deg; degrees are expected", place.longitude / kDegree);
  }
  if (!(std::abs(place.height) <= kHighest)) {
    return fmt::format("height {:.1f} m; metres above the ellipsoid are expected", place.height);
  }
  return {};
}

bool are_sigmas(const Vector3d& sigma) { return (sigma.array() > 0).all(); }

std::string fault_of(const GeodeticFix& fix) {
  if (!std::isfinite(fix.time)) return fmt::format("the time of a fix, {} s, must be finite", fix.time);
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!finite(fix.position.latitude) || !finite(fix.position.longitude) || !finite(fix.position.height)) {
    return "a position must be finite; leave out what a receiver says without a fix";
  }
  if (std::string fault = fault_of(fix.position); !fault.empty()) return fault;
  if (!fix.sigma_position.allFinite() || !are_sigmas(fix.sigma_position)) {
    return "the sigmas of a position must be above zero";
  }
  if (!fix.velocity) return {};
  if (!fix.velocity->value.allFinite()) return "a velocity must be finite; leave it out where there is none";
  if (!are_sigmas(fix.velocity->sigma)) return "the sigmas of a velocity must be above zero";
  return {};
}

}  // namespace piste
