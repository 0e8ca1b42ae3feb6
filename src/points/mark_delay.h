#pragma once
/// The delay from marks to what they mark, from the places that the marks carry.

#include <cstddef>
#include <string>
#include <vector>

#include "piste/configuration/replay_config.h"
#include "piste/replay/replay.h"

namespace piste {

/// How late what is marked comes, such as the shutter of a camera whose places a bundle adjustment has found.
struct MarkDelay {
  double delay = 0, sigma = 0;         ///< s
  Vector3d offset = Vector3d::Zero();  ///< that all places have from the track: north, east, down [m]
  double residual = 0;                 ///< rms of a component that is left [m]
  std::size_t used = 0;                ///< marks within three spreads of the others
};

/// Fits place = p(t + delay) + offset + e by least squares, p being the track of the point, in Gauss-Newton steps:
/// p(t + d + δ) ≈ p(t + d) + v δ. Marks that lie more than three spreads (1.4826 times the median magnitude) from
/// the others are left out. Errors e of neighbouring marks may be correlated, as errors of a track are: the sigma is
/// that of the mean of a series (standard_error_of_series). `marks`: with places, at their instants without a delay.
/// Throws DataError, naming `file`: fewer than five marks, a body that does not move, a mark outside of the run, or
/// steps that do not end within ten seconds of the marks.
MarkDelay find_mark_delay(const Replay& run, const std::vector<Mark>& marks, const OutputPoint& point,
                          const std::string& file);

}  // namespace piste
