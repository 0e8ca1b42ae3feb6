#pragma once
/// Reads the keys of what carries the IMU, and of the sensors that go with it.

#include "piste/core/options.h"
#include "piste/io/config.h"

namespace piste {

/// Reads the map `vehicle: {kind, contact, mounting, sigma_contact, sigma_mounting}`. Nothing if the key is missing or
/// `off`. Throws ConfigError.
std::optional<VehicleOptions> read_vehicle(const Config& config);

}  // namespace piste
