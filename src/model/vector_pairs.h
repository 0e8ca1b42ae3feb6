#pragma once
/// The observations of an alignment in motion: vectors in body axes from dead reckoning, and the same vectors in w from
/// fixes.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/model/alignment.h"

namespace piste {

/// One vector in both frames: β = R α + a constant or a line that is projected out later.
struct VectorPair {
  double time = 0;   ///< since the first fix
  Vector3d alpha;    ///< dead reckoned, in the body axes of the first fix
  Vector3d beta;     ///< from the fix, without the part of gravity, in w
  double sigma = 1;  ///< of the fix, one axis
};

/// The pairs of a window: for each fix one of its velocity and one of its position, as far as it has them.
struct WindowPairs {
  std::vector<VectorPair> velocity, position;
};

/// Dead reckons from the first fix to the last. Returns nullopt if the IMU has a gap in between or ends before.
std::optional<WindowPairs> pairs_of(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                    const GnssOptions& receiver, const GyroBias& bias, const Vector3d& gravity);

/// Subtracts from both vectors of the pairs their weighted mean; with `lines`, their weighted regression line over
/// time.
std::vector<VectorPair> projected_out(std::vector<VectorPair> pairs, bool lines);

}  // namespace piste
