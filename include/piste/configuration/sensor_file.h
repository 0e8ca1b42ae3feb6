#pragma once
/// Reads and writes sensor files, such as those in `config/sensors`.

#include <filesystem>
#include <string>
#include <string_view>

#include "piste/core/sensor.h"
#include "piste/io/config.h"

namespace piste {

/// The sensor file that a key names. This is a path relative to the folder of the file with the key. If there is no
/// such file, it is the name of one that comes with piste in shared_folder(), such as `xsens_mt9a`. Throws ConfigError
/// with the known names if there is neither.
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
