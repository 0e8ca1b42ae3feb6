#pragma once
/// What the filter itself estimates of a pair of logs: how far their clocks are apart, where the antenna sits, and how
/// noisy the IMU is in motion.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "piste/core/options.h"
#include "piste/inspect/inspection.h"
#include "piste/tune/likeliest_noise.h"
#include "search/work.h"

namespace piste {

/// What is known of the clock in a ConditioningOptions.
struct ToldClock {
  /// Of its offset [s]; infinite: nothing is known. Where that is more than 20 ms, offsets next to it are tried too: as
  /// far as it may be off, and half a second where nothing is known.
  double sigma;
  bool with_drift = false;  ///< whether its drift is known, so that none is sought
};

/// The largest drift of a clock that is one: loggers were 14 to 310 ppm off.
constexpr double kMostClockDrift = 3.5e-4;

/// s of motion that calibrate() looks at, and of what comes before it.
constexpr double kFirstMotion = 150, kBeforeMotion = 30;

/// Where a receiver says that the body moves: between departure and arrival, as the start judges a departure.
Interval motion_of(const std::vector<GeodeticFix>& fixes, const StartOptions& options);

/// Rows of the IMU in a stretch of a log, as far as it has them.
double rows_in(const Recording& recording, double seconds);

/// What runs cost of which `jobs` go at a time, each of `rows` rows: in rows of the IMU that are filtered once.
inline double cost_of_runs(double runs, double rows, std::size_t jobs) {
  return runs * rows / static_cast<double>(std::max<std::size_t>(1, jobs));
}

/// What a rough search for the noise costs that filters so many seconds of a log, `jobs` runs at a time.
double cost_of_search(const Recording& recording, double seconds, std::size_t jobs);

/// What calibrate() costs in these rows, as far as it is known beforehand.
double cost_of_calibration(const Recording& recording, const ToldClock& clock, std::size_t jobs);

/// Where the antenna may be: metres from the IMU, or in the same housing, as in a phone.
enum class Antenna { kNearBy, kInHousing };

/// What says that a receiver with this noise has a coloured error, where it has one.
inline DriftBy drift_by(const ReceiverNoise& noise) {
  return noise.by_claim ? DriftBy::kClaim : noise.drift > 0 ? DriftBy::kMotion : DriftBy::kRounding;
}

/// Replays the first minutes of motion with lever arm and delay as states, for several clock offsets and noises, and
/// keeps those with the most likely innovations (tune/evidence.h). The noise of the IMU and the
/// errors of the receiver are those of likeliest_noise() (tune/likeliest_noise.h), with `jobs` filter runs at a time.
/// Where the last minutes of motion are far from the first, the same filter estimates the offset there too, and so the
/// drift of the clock if it is significant.
/// Where heights stand still and came out too exact, all is done again with the errors of their rounding
/// (tune/standing_heights.h).
/// Nothing if no candidate starts, or if the clock is not known to 0.1 s and fixes are as likely with one that is
/// seconds off. Sigmas of positions that are far too large make it so, and are made smaller first. @pre `options` has
/// one receiver, `recording` too. `work` gets the steps, and of more of them than cost_of_calibration() expects.
std::optional<Calibration> calibrate(const Recording& recording, ConditioningOptions conditioning,
                                     FilterOptions options, const ToldClock& clock, Antenna antenna = Antenna::kNearBy,
                                     std::size_t jobs = 1, const Work& work = {});

}  // namespace piste
