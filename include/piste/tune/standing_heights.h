#pragma once
/// Heights that a receiver rounds so coarsely that they stand still while the body rises and sinks.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// s that the error of a height which stands still lasts: as long as a road is level.
inline constexpr double kStandingTime = 300;

/// What rounding adds to the heights of a receiver where hardly any differs from the one before. Such an error does not
/// show in what follows from one fix to the next, so that the likelihood takes them for exact.
struct StandingHeights {
  double slow = 0;   ///< its 1-sigma, the step / √12 [m]; 0: they do not stand still
  double white = 0;  ///< that of a single fix, half a step, for where heights go to and fro between two [m]

  /// Whether `sigma` [m] of heights is no more than that of rounding, as if its errors were independent. A larger one
  /// is determined by more than heights that repeat themselves.
  bool too_small(double sigma) const {
    constexpr double kOfRounding = 1.5;
    return sigma < kOfRounding * slow;
  }
  double sigma() const;         ///< of both together
  GaussMarkov process() const;  ///< of the slow one, as the coloured error of a receiver, which has next to no other
};

/// Whether a coloured error is that of rounded heights, and of nothing else.
bool is_of_heights_alone(const PositionDrift& drift);

/// The heights stand still where three in four are within a millimetre of the one before, or back at that which was
/// before it, and changes are by multiples of one step; a metre, where none changes. `height`: of the fixes, in their
/// order [m].
StandingHeights standing_heights(const std::vector<double>& height);
/// The same of the fixes of a receiver.
StandingHeights standing_heights(const std::vector<GeodeticFix>& fixes);
StandingHeights standing_heights(const std::vector<GnssFix>& fixes, const World& world);

}  // namespace piste
