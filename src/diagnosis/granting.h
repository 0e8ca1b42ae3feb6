#pragma once
/// What the kinds of causes have in common.

#include <algorithm>
#include <string>
#include <utility>

#include "diagnosis/causes.h"
#include "piste/core/state_table.h"

namespace piste {

constexpr double kWideClock = 0.3;  ///< s: 1-sigma of a clock's offset that is granted

/// What `values` gain that were searched for, and not integrated over as states are: each pays for that.
inline Granted searched(double gain, std::string text, int values = 1) {
  constexpr double kSearched = 3;
  return {gain - kSearched * values, std::move(text)};
}

/// Lets the run estimate the block.
inline void want(FilterOptions& options, Block block) {
  if (!options.estimates(block)) options.estimate.push_back(block);
}

/// Whether some receiver has positions, and whether receiver i has velocities, that are used.
inline bool some_positions(const FilterOptions& options) {
  return std::any_of(options.gnss.begin(), options.gnss.end(), [](const GnssOptions& g) { return g.use_position; });
}
inline bool has_velocities(const Told& told, std::size_t i) {
  const auto& fixes = told.log.gnss[i];
  return told.options.gnss[i].use_velocity &&
         std::any_of(fixes.begin(), fixes.end(), [](const GnssFix& f) { return f.velocity.has_value(); });
}

}  // namespace piste
