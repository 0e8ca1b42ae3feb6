#pragma once
/// Reads the true errors of a simulated IMU from truth.json.

#include <filesystem>
#include <optional>
#include <string>

#include "piste/math/so3.h"

namespace piste {

/// The true errors of an IMU, in SI: measured = (1 + scale) M true + bias + drift + noise.
struct ImuTruth {
  /// Means of the in-run drift and of the true signal.
  struct Phase {
    Vector3d drift, signal;
  };
  struct Triad {
    Vector3d bias, scale;
    Matrix3d misalignment;                    ///< M
    std::optional<Phase> before, run, after;  ///< at rest before the start, under way, at rest after the stop
  };
  Triad gyro, accel;
};

/// Reads the member `imus.NAME` of a truth.json. Throws DataError if the file cannot be read or a member is missing.
ImuTruth read_truth(const std::filesystem::path& file, const std::string& name);

}  // namespace piste
