#pragma once
/// The fit of windows of an IMU's forces to a track's velocities.

#include <vector>

#include "motion_windows.h"

namespace piste {

/// The forces carried to the window's start by the gyroscopes, and the attitudes on the way.
struct CarriedWindow {
  std::vector<Quaterniond> attitude;
  std::vector<Vector3d> velocity;
  std::vector<Matrix3d> swing;  ///< of the antenna, by the lever arm
};

/// Each window carried with the gyroscopes times `turn`, the factor and the axes of a reading of their labels.
std::vector<CarriedWindow> carry_all(const std::vector<MotionWindow>& windows, const Matrix3d& turn);

/// Wahba's problem with a free scale: β ≈ scale R α.
struct WindowFit {
  Matrix3d R;
  double scale = 0, mean_square = 0;  ///< mean square of what is left [m²/s²]
};

/// The fits of all windows, with one lever arm in common.
struct JointFit {
  std::vector<WindowFit> fits;
  Vector3d lever_arm = Vector3d::Zero();  ///< in the accelerometers' axes
};

/// Fits each window for its rotation and scale, then all of them for the lever arm, then each once more. `gravity`:
/// whether the forces hold it; `mirrored`: for rotations that also mirror.
JointFit fit_all(const std::vector<MotionWindow>& windows, const std::vector<CarriedWindow>& carried, bool gravity,
                 bool mirrored);

}  // namespace piste
