#pragma once
// Parts of every start, however its heading was found: position, velocity, boresight and covariance.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/filter/filter.h"
#include "piste/math/units.h"
#include "start/start_rest.h"

namespace piste {

/// The receiver that starts the run, with its fixes at their times of validity.
struct Receiver {
  std::vector<GnssFix> fixes;
  GnssOptions options;
};

/// The time at which a run begins, and the rest at that time, if any.
struct Beginning {
  double time;
  std::optional<Rest> rest;
};

/// A run begins with the log, or with the first fix if the body moves before it.
Beginning beginning(const Log& log, const Receiver& receiver, const StartOptions& options);

/// The first receiver that has fixes. Throws DataError if none has.
Receiver first_receiver(const Log& log, const FilterOptions& options);

/// The attitude at `begin` from that at `end`: R_wb(begin) = Exp(T ω_ie) R_wb(end) Cᵀ, with T = end − begin. C is the
/// rotation from begin to end by the gyroscopes without `bias`. The first factor is there because w rotates with the
/// Earth.
Quaterniond carry_back(const Log& log, const Quaterniond& q_end, double begin, double end, const Vector3d& bias);

/// The attitude nearest to q_nb for which `down_b` (body axes, any length) points down. Unlike Euler angles it has no
/// singularity where a body axis is vertical.
Quaterniond levelled(const Quaterniond& q_nb, const Vector3d& down_b);

/// R_wn at the first fix of a receiver from `time` on that does not contradict the next two, or at its last fix. @pre
/// There is a fix.
Quaterniond local_level(const World& world, const Receiver& receiver, double time);

/// Sets position, velocity and their covariance of a stationary body, from the first fix at or after the start. `start`
/// has its attitude. A fix that disagrees with the next two is skipped. The sigmas are loose, as the filter uses the
/// same fix again.
void place_at_rest(const World& world, Start& start, const Receiver& receiver, const StartOptions& options);

/// The start of a moving body, with the given heading (in the local level) and its 1-sigma [rad]. Position and velocity
/// are those of first_motion(). Roll and pitch are those for which the specific force gives its acceleration. The
/// sigmas are loose, as the filter uses the same fixes again. The velocity is measured, so that its error is
/// independent of that of the heading.
/// Throws DataError if no IMU sample follows `time`.
Start start_on_the_move(const Log& log, const FilterOptions& options, const Receiver& receiver, double time,
                        double heading, double sigma);

/// Sets the covariance of the attitude from its 1-sigma about the axes of the local level [rad]. The errors of position
/// and velocity δv become uncorrelated with that of the attitude.
void set_attitude_sigma(const World& world, Start& start, const Vector3d& sigma);

/// 1-sigma of the attitude of a start about the axes of the local level [rad].
Vector3d attitude_sigma(const World& world, const Start& start);

/// Sets the boresight from the first reference attitude at or after the start, R_rb = R_wrᵀ R_wb. Does nothing if the
/// boresight is not estimated or there is no reference attitude.
void set_boresight(Start& start, const Log& log, const FilterOptions& options);

}  // namespace piste
