#pragma once
/// How large the white noise of an IMU can be, by its samples alone: motion adds to its Allan deviation, and no motion
/// takes from the noise that the sensor has at rest.

#include "piste/core/log.h"

namespace piste {

/// White noise of gyroscopes and accelerometers, as densities in SI.
struct WhiteNoise {
  double gyro, accel;
};

/// Both limits.
struct WhiteNoiseRange {
  WhiteNoise least{0, 0}, most;
};

/// The limits of the noise under way, from Allan deviations times √τ, over the three axes together.
///
/// `most` is by the samples under way at τ = 0.1 s: white noise of that density would make it alone. A shorter time
/// could be that of the sensor's own low-pass. Infinite where there are too few samples.
///
/// `least` is by those at rest, less what chance may add (1 %): the smallest at times from a sample to 1 s that the
/// rests show, as an idling engine adds to the short ones, and a person who sways to the long ones. Zero where there is
/// too little rest.
WhiteNoiseRange white_noise_range(const Log& log);

}  // namespace piste
