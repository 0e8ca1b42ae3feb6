#pragma once
/// Functions that all kinds of causes share.

#include <algorithm>
#include <string>
#include <utility>

#include "diagnosis/causes.h"
#include "piste/core/error.h"
#include "piste/core/state_table.h"

namespace piste {

constexpr double kWideClock = 0.3;  ///< s: 1-sigma prior of the clock offset of a tested cause

/// The gain of the log-likelihood for an error of the start, which shows only until the filter has estimated it. For
/// any other cause the gain is lasting_gain().
inline double gained(const Evidence& tested, const Evidence& base) { return tested.likelihood - base.likelihood; }

/// A cause whose `values` were searched for, not integrated over as states are: its gain is reduced for each of them.
inline TestedCause searched(double gain, std::string text, Change change = {}, int values = 1) {
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

/// Estimates the start again, after a change of the log or of its options. Returns whether there is one.
inline bool start_anew(FilterInput& input, const InitialHeading& heading) {
  try {
    input.start = find_start(input.log, input.options, heading).start;
  } catch (const Error&) {
    return false;
  }
  input.start.covariance = input.start.covariance.topLeftCorner(9, 9).eval();
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
inline bool has_velocities(const FilterInput& input, std::size_t i) {
  const auto& fixes = input.log.gnss[i];
  return input.options.gnss[i].use_velocity &&
         std::any_of(fixes.begin(), fixes.end(), [](const GnssFix& f) { return f.velocity.has_value(); });
}

}  // namespace piste
