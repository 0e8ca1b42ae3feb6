#pragma once
/// Detects spikes, isolated samples of an IMU that no motion of a body explains, and interpolates them.

#include <cstddef>
#include <span>
#include <vector>

#include "core/row_gaps.h"
#include "piste/core/behaviour.h"
#include "piste/math/so3.h"

namespace piste {

/// One or two rows of one axis that depart from the line between their neighbours.
struct Spike {
  std::size_t row = 0, count = 1;
  int axis = 0;
  double departure = 0;  ///< the smaller one of the rows, absolute
  double spread = 0;     ///< rms error of such lines at the rows around
};

/// Finds the spikes of rates or forces `values`, in the order of axes and then of rows. If these are increments,
/// `period` is that of the rows, and 1 otherwise.
///
/// l(i) is the line between row i − 1 and row i + n. Rows i to i + n − 1 are a spike (n is 1 or 2) if all of them are
/// on the same side of l, and their departure exceeds three bounds. The first is `abruptness`. The second is `sigmas`
/// times 1.4826 times the median absolute departure of the rows within `around` from their own lines. The third is
/// `furthest` times the largest of these departures. Other candidate rows are left out of the latter two, and there may
/// be only few of them. Vibration, impacts that ring, and steps therefore are no spikes. Rows next to a gap or an end
/// of the log are not tested.
std::vector<Spike> find_spikes(std::span<const double> time, const RowGaps& gaps, const std::vector<Vector3d>& values,
                               double period, const Abruptness& abruptness, const SpikeOptions& options = {});

/// Interpolates the rows of spikes linearly between their neighbours.
void interpolate_spikes(std::vector<Vector3d>& values, const std::vector<Spike>& spikes);

}  // namespace piste
