#pragma once
/// When a photograph was taken.

#include <string>

#include "math/gps_time.h"

namespace piste {

/// DateTimeOriginal with SubSecTimeOriginal, less OffsetTimeOriginal if it is there, of a JPEG (Exif 2.32, CIPA
/// DC-008): the camera's clock, taken as UTC. Throws DataError if it has none.
GpsTime exif_time(const std::string& file);

}  // namespace piste
