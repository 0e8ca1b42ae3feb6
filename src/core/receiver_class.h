#pragma once
/// Errors of receivers whose logs state no sigmas: the usual errors of their kind of solution.

#include <array>
#include <string_view>

#include "piste/core/log.h"
#include "piste/math/so3.h"

namespace piste {

/// The usual total error of a kind of solution.
struct ReceiverClass {
  FixQuality quality;
  const char* name;
  std::array<double, 3> axes;  ///< 1-sigma of north, east and down [m]
  double share;                ///< slow share of it: the remainder is white from fix to fix

  Vector3d sigma() const { return {axes[0], axes[1], axes[2]}; }
};

/// One row for each quality. Sources:
///  - single, and where nothing is known: GPS SPS Performance Standard of 2020: 95 % within 8 m of plan and
///    13 m of height at an average site, which are 3.3 m and 6.6 m for an axis; rounded. Orbits, clocks and atmosphere,
///    which last minutes, make up all but some decimetres.
///  - differential: data sheet of the u-blox NEO-M8 with SBAS: half of the plan errors within 2 m, which are 1.7 m for
///    an axis; heights are twice as wrong.
///  - float, and precise point positioning: decimetres (Groves 2013, chapter 10), while ambiguities converge.
///  - fixed: data sheet of the u-blox ZED-F9P: 1 cm and 1 ppm of the baseline, here of 10 km; half of it multipath,
///    which lasts.
///  - dead reckoned: as single, whose last fix it carries on.
inline constexpr std::array kReceiverClasses{
    ReceiverClass{FixQuality::kUnknown, "single point", {3, 3, 6}, 0.95},
    ReceiverClass{FixQuality::kSingle, "single point", {3, 3, 6}, 0.95},
    ReceiverClass{FixQuality::kSbas, "differential", {1.7, 1.7, 3.4}, 0.95},
    ReceiverClass{FixQuality::kDifferential, "differential", {1.7, 1.7, 3.4}, 0.95},
    ReceiverClass{FixQuality::kPrecise, "precise point", {0.1, 0.1, 0.2}, 0.9},
    ReceiverClass{FixQuality::kFloat, "float", {0.3, 0.3, 0.6}, 0.95},
    ReceiverClass{FixQuality::kFixed, "fixed", {0.015, 0.015, 0.03}, 0.7},
    ReceiverClass{FixQuality::kDeadReckoned, "dead reckoned", {3, 3, 6}, 0.95},
};

/// The names of the qualities in configurations.
inline constexpr std::array<std::string_view, kQualities> kQualityNames{"unknown", "single", "sbas",  "differential",
                                                                        "ppp",     "float",  "fixed", "dead_reckoned"};

constexpr const ReceiverClass& receiver_class(FixQuality quality) {
  return kReceiverClasses[static_cast<std::size_t>(quality)];
}

/// The class of a log: that of the least certain quality that a tenth of its fixes have.
const ReceiverClass& receiver_class(const std::vector<GeodeticFix>& fixes);

}  // namespace piste
