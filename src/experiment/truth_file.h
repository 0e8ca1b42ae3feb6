#pragma once
/// What the simulator put into one IMU, as truth.json tells it.

#include <filesystem>
#include <optional>
#include <string>

#include "piste/math/so3.h"

namespace piste {

/// measured = (1 + scale) M true + bias + drift + noise. SI.
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

/// The member `imus.NAME` of a truth.json. Throws DataError where the file cannot be read or lacks a member.
ImuTruth read_truth(const std::filesystem::path& file, const std::string& name);

}  // namespace piste
