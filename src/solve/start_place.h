#pragma once
// The parts that every start is made of, however its heading was found.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/math/units.h"
#include "piste/solve/filter.h"

namespace piste {

/// 1-sigma [rad] of the tilt of a level start: loose, as the filter sees the same samples again.
inline constexpr double kTiltSigma = 2 * kDegree;

/// The receiver that starts the run, with its fixes.
struct Receiver {
  const std::vector<GnssFix>* fixes;
  const GnssOptions* options;
};

/// The first receiver that has fixes. Throws DataError where none has.
Receiver first_receiver(const Log& log, const FilterOptions& options);

/// The attitude at `begin` from the one at `end`: R_wb(begin) = Exp(T ω_ie) R_wb(end) Cᵀ with T = end − begin and C,
/// the gyro's turn from begin to end less `bias`. The Earth turns w along with it, hence the first factor.
Quaterniond carry_back(const Log& log, const Quaterniond& q_end, double begin, double end, const Vector3d& bias);

/// The attitude nearest to q_wb whose down axis lies along `down_b` (body axes, any length). Unlike angles it has no
/// singularity where a body axis stands upright.
Quaterniond levelled(const Quaterniond& q_wb, const Vector3d& down_b);

/// Sets position, velocity and their covariance from the first fix at or after the start, for the attitude that the
/// start has. A fix that disagrees with the two after it is passed over. The sigmas are loose, as the filter sees the
/// same fix again.
void place(Start& start, const Receiver& receiver, bool still);

/// Sets the covariance of the attitude, axes of w [rad].
void set_attitude_sigma(Start& start, const Vector3d& sigma);

/// Sets the boresight from the first reference attitude at or after the start, R_rb = R_wrᵀ R_wb, where it is estimated
/// and there is one.
void set_boresight(Start& start, const Log& log, const FilterOptions& options);

/// Whether the options name the block among those to be estimated.
bool estimates(const FilterOptions& options, Block block);

}  // namespace piste
