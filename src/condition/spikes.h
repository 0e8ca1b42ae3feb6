#pragma once
/// Finds and mends isolated samples of an IMU that no motion of a body explains.

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "condition/row_gaps.h"
#include "piste/math/so3.h"

namespace piste {

/// What makes a sample a spike. All conditions must hold.
struct SpikeOptions {
  /// s on either side with which a spike is compared: an impact rings that long, and steps return within it.
  double around = 2;
  /// Rows that must be on either side without a gap: with fewer, the motion around is not known.
  std::size_t fewest = 8;
  /// Least departure from the line, in robust sigmas of such lines around: white noise has one beyond 8 in 1e15.
  double sigmas = 20;
  /// Least departure in parts of the furthest one around: a knock has neighbours of a tenth to a half of its peak.
  double furthest = 6;
  /// Other departures of the same size that may be around: what comes back again and again is motion.
  std::size_t most_others = 2;
};

/// What a body at most does in one sample: a rate of change, and what is not worth mending however fast the log is.
struct Abruptness {
  double per_second, least;
};
/// rad/s² and rad/s. A skier's landing turns the body with some 100 rad/s².
inline constexpr Abruptness kAbruptGyro{250, 1};
/// m/s³ and m/s². The force of a landing grows within 20 ms or more to some 10 g.
inline constexpr Abruptness kAbruptAccel{5000, 20};

/// One or two rows of one axis that depart from the line between the rows beside them.
struct Spike {
  std::size_t row = 0, count = 1;
  int axis = 0;
  double departure = 0;  ///< the smaller one of the rows, absolute
  double spread = 0;     ///< rms by which such lines miss the rows around
};

/// Finds the spikes of rates or forces `values`, in the order of axes and then of rows. If these are increments,
/// `period` is that of the rows, and 1 otherwise.
///
/// With l(i) the line between row i − 1 and row i + n, rows i to i + n − 1 are a spike (n is 1 or 2) if all of them are
/// on the same side of l, and their departure exceeds `abruptness`, `sigmas` times the median absolute departure of
/// the rows within `around` from their own lines (times 1.4826), and `furthest` times the largest one of these. Rows
/// that may be spikes themselves are left out of the latter two, and there may be few of them. Vibration, impacts that
/// ring, and steps therefore are no spikes. Rows beside a gap or an end of the log are not judged.
std::vector<Spike> find_spikes(std::span<const double> time, const RowGaps& gaps, const std::vector<Vector3d>& values,
                               double period, const Abruptness& abruptness, const SpikeOptions& options = {});

/// Replaces the rows of spikes by the line between the rows beside them.
void mend(std::vector<Vector3d>& values, const std::vector<Spike>& spikes);

}  // namespace piste
