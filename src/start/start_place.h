#pragma once
// What every start needs, however its heading was found: position, velocity, boresight and covariance.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/filter/filter.h"
#include "piste/math/units.h"
#include "start/start_rest.h"

namespace piste {

/// The receiver that starts the run, with its fixes at the times where they belong.
struct Receiver {
  std::vector<GnssFix> fixes;
  GnssOptions options;
};

/// The time at which a run begins, and the rest there.
struct Beginning {
  double time;
  std::optional<Rest> rest;
};

/// A run begins with the log, or with the first fix if the body moves before it.
Beginning beginning(const Log& log, const Receiver& receiver, const StartOptions& options);

/// The first receiver that has fixes. Throws DataError if none has.
Receiver first_receiver(const Log& log, const FilterOptions& options);

/// The attitude at `begin` from that at `end`: R_wb(begin) = Exp(T ω_ie) R_wb(end) Cᵀ, with T = end − begin and C the
/// rotation from begin to end by the gyroscopes without `bias`. The first factor is there because w rotates with the
/// Earth.
Quaterniond carry_back(const Log& log, const Quaterniond& q_end, double begin, double end, const Vector3d& bias);

/// The attitude nearest to q_nb for which `down_b` (body axes, any length) points down. Unlike with Euler angles, there
/// is no singularity where a body axis stands upright.
Quaterniond levelled(const Quaterniond& q_nb, const Vector3d& down_b);

/// R_wn at the place of a receiver at a time: that of the first fix at or after it that does not contradict the next
/// two, or of the last fix. @pre there is a fix
Quaterniond local_level(const World& world, const Receiver& receiver, double time);

/// Sets position, velocity and their covariance from the first fix at or after the start of a body at rest, with the
/// attitude that the start has. A fix that disagrees with the two after it is skipped. The sigmas are loose, as the
/// filter uses the same fix again.
void place_at_rest(const World& world, Start& start, const Receiver& receiver, const StartOptions& options);

/// The start of a body that moves, with the given heading (in the local level) and its 1-sigma [rad]: position and
/// velocity are those of first_motion(), and roll and pitch those with which the specific force makes its acceleration.
/// The sigmas are loose, as the filter uses the same fixes again; a velocity that the receiver measured does not turn
/// with the heading.
Start start_on_the_move(const Log& log, const FilterOptions& options, const Receiver& receiver, double time,
                        double heading, double sigma);

/// Sets the covariance of the attitude from its 1-sigma about the axes of the local level [rad]. Position and velocity
/// are taken to be known by themselves: their errors do not turn with that of the attitude.
void set_attitude_sigma(const World& world, Start& start, const Vector3d& sigma);

/// 1-sigma of the attitude of a start about the axes of the local level [rad].
Vector3d attitude_sigma(const World& world, const Start& start);

/// Sets the boresight from the first reference attitude at or after the start, R_rb = R_wrᵀ R_wb. Does nothing if the
/// boresight is not estimated or there is no reference attitude.
void set_boresight(Start& start, const Log& log, const FilterOptions& options);

}  // namespace piste
