#pragma once
/// Reads the keys of the vehicle that carries the IMU, and of its sensors.

#include "piste/configuration/imu_source.h"
#include "piste/core/options.h"
#include "piste/io/config.h"

namespace piste {

/// The options of a kind of vehicle. A bicycle has no springs.
VehicleOptions vehicle_of(VehicleOptions::Kind kind);

/// Reads a first-order Gauss-Markov process of one number, `KEY: {sigma, correlation_time}`; `otherwise` without the
/// key. `value`: what sigma is. Throws ConfigError.
GaussMarkov read_process(const Config& config, std::string_view key, const Dimension& value, GaussMarkov otherwise);

/// Reads the map `vehicle: {kind, contact, mounting, sigma_contact, sigma_mounting, slip}`. Nothing if the key is
/// missing or `off`. Throws ConfigError.
std::optional<VehicleOptions> read_vehicle(const Config& config);

/// Read the maps `odometer: {file, sigma, scale, slip, signed}`, `barometer: {file, sigma, drift: {sigma,
/// correlation_time}}` and `heading: {file, sigma, baseline}`, whose options they set in `filter`. Nothing if the key
/// is missing. Throw ConfigError.
std::optional<LogFile> read_odometer(const Config& config, FilterOptions& filter);
std::optional<LogFile> read_barometer(const Config& config, FilterOptions& filter);
std::optional<LogFile> read_dual_heading(const Config& config, FilterOptions& filter);

/// Reads the map `magnetometer: {sigma, hard_iron, soft_iron, disturbance: {sigma, correlation_time}, year, field,
/// declination, unit, interval}`: its options are set in `filter`, and the field for its log is returned. Throws
/// ConfigError.
MagneticConditioning read_magnetometer(const Config& config, FilterOptions& filter);

}  // namespace piste
