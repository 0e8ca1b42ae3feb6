#pragma once
/// The page of `allan`.

#include <string>

#include "piste/recordings/allan.h"

namespace piste {

/// A self-contained HTML file without network: the numbers of a data sheet with their intervals, the curve of every
/// axis with its band, its model and the model's parts, the processes, the tested models with their penalty, a
/// comparison of the IMUs, and the sensor file.
std::string allan_page(const AllanFindings& findings, const std::string& sensor_file, const std::string& version);

}  // namespace piste
