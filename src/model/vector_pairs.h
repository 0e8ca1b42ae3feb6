#pragma once
/// What dead reckoning and fixes say of the same vectors: the observations of an alignment in motion.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/model/alignment.h"

namespace piste {

/// One vector seen from both sides, β = R α + what is projected out.
struct VectorPair {
  double time = 0;   ///< since the first fix
  Vector3d alpha;    ///< dead reckoned, in the body axes of the first fix
  Vector3d beta;     ///< of the fix without gravity's part, in w
  double sigma = 1;  ///< of the fix, one axis
};

/// The pairs of a window, one a fix and kind.
struct WindowPairs {
  std::vector<VectorPair> velocity, position;
};

/// Dead reckons from the first fix to the last. nullopt where the IMU has a gap in between or ends before.
std::optional<WindowPairs> pairs_of(std::span<const ImuSample> imu, std::span<const GnssFix> fixes,
                                    const GnssOptions& receiver, const GyroBias& bias, const Vector3d& gravity);

/// Subtracts from both sides their weighted mean, and with `lines` their weighted regression line over time.
std::vector<VectorPair> projected_out(std::vector<VectorPair> pairs, bool lines);

}  // namespace piste
