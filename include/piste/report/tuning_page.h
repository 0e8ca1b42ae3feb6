#pragma once
/// The page of `tune`.

#include <string>

#include "piste/tune/likeliest_noise.h"

namespace piste {

/// A self-contained HTML file without network or JavaScript: how much likelier the innovations have become, each number
/// with its interval, what it was before and whether the data determine it, as a table and as a picture; the noise at
/// rest, NIS of each source, and the sensor file.
std::string tuning_page(const Tuning& tuning, const std::string& title, const std::string& sensor_file,
                        const std::string& version);

}  // namespace piste
