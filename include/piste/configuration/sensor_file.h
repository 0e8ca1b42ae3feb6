#pragma once
/// Reads and writes sensor files, such as those in `config/sensors`.

#include <filesystem>
#include <string>
#include <string_view>

#include "piste/core/sensor.h"
#include "piste/io/config.h"

namespace piste {

/// The sensor file that a key names: a path, relative to the folder of the file in which it stands; or, where no such
/// file is there, the name of one that comes with piste, such as `xsens_mt9a` (shared_folder() holds them). Throws
/// ConfigError if there is neither, with the names that are known.
std::filesystem::path sensor_file(const Config& config, std::string_view key);

/// Reads a sensor file. Throws ConfigError `FILE:LINE: …`.
ImuSensor read_sensor(const std::filesystem::path& file);
ImuSensor read_sensor(const Config& config);

/// The sensor with its noise, biases and drifts as `digits` digits of the units that its file is written in. The range
/// has four.
ImuSensor rounded(ImuSensor sensor, int digits);

/// The text of a sensor file. It reads back as the same sensor.
std::string sensor_text(const ImuSensor& sensor);

}  // namespace piste
