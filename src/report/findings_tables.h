#pragma once
/// The errors of one IMU in one run as rows of text, which a terminal and a page share.

#include <string>
#include <vector>

#include "piste/fit/imu_fit.h"

namespace piste {

/// Rows of cells. The first row has the heads of the columns.
using TextTable = std::vector<std::vector<std::string>>;

/// For each axis the biases and scales with their total sigmas.
TextTable findings_by_axis(const Findings& found);

/// The 3 × 3 matrices of accelerometers and gyroscopes; without those that were not fitted.
std::vector<TextTable> findings_by_triad(const Findings& found);

/// "rest 302400.0 to 302460.0 s, run …, rest …".
std::string phases_text(const Findings& found);

}  // namespace piste
