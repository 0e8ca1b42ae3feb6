#pragma once
/// What the kinds of causes have in common.

#include <algorithm>
#include <string>
#include <utility>

#include "diagnosis/causes.h"
#include "piste/core/error.h"
#include "piste/core/state_table.h"

namespace piste {

constexpr double kWideClock = 0.3;  ///< s: 1-sigma of a clock's offset that is granted

/// By how much likelier the innovations have become, where a cause shows until the filter has found it, and no longer:
/// an error of the start. Of any other cause it is lasting_gain().
inline double gained(const Evidence& granted, const Evidence& base) { return granted.likelihood - base.likelihood; }

/// What `values` gain that were searched for, and not integrated over as states are: each pays for that.
inline Granted searched(double gain, std::string text, Change change = {}, int values = 1) {
  constexpr double kSearched = 3;
  return {gain - kSearched * values, std::move(text), std::move(change)};
}

/// Moves the time of every measurement that is not the IMU's by `later(time)`.
template <class Later>
void move_fixes(Log& log, Later&& later) {
  const auto move = [&](auto& fixes) {
    for (auto& fix : fixes) fix.time += later(fix.time);
  };
  std::ranges::for_each(log.gnss, move);
  std::ranges::for_each(log.attitude, move);
  move(log.speed);
  move(log.height);
  move(log.heading);
}

/// Finds the start anew, as the log and what is told of it may have changed. Returns whether there is one.
inline bool start_anew(Told& told, const InitialHeading& heading) {
  try {
    told.start = find_start(told.log, told.options, heading).start;
  } catch (const Error&) {
    return false;
  }
  told.start.covariance = told.start.covariance.topLeftCorner(9, 9).eval();
  return true;
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
