#pragma once
/// Levelling: the attitude of a stationary body, from its accelerometers.

#include "piste/math/so3.h"

namespace piste {

/// The attitude of a body at rest, from its mean specific force in body axes and a given heading [rad]: w's down axis
/// lies along −`mean_force`.
Quaterniond level(const Vector3d& mean_force, double heading);

}  // namespace piste
