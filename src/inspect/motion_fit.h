#pragma once
/// Fits the forces of an IMU to the velocities of a track, in windows.

#include <vector>

#include "motion_windows.h"

namespace piste {

/// One window: the integral of the forces in the axes at the beginning of the window, and the rotations since then.
struct CarriedWindow {
  std::vector<Quaterniond> attitude;
  std::vector<Vector3d> velocity;
  std::vector<Matrix3d> swing;  ///< times the lever arm: velocity of the antenna by rotation
};

/// Integrates each window with the gyroscopes multiplied by `turn`, the hypothesis of factor and axes.
std::vector<CarriedWindow> carry_all(const std::vector<MotionWindow>& windows, const Matrix3d& turn);

/// The solution of Wahba's problem with a free scale: β ≈ scale R α.
struct WindowFit {
  Matrix3d R;
  double scale = 0, mean_square = 0;  ///< mean square of the residuals [m²/s²]
};

/// The fits of all windows, with one lever arm in common.
struct JointFit {
  std::vector<WindowFit> fits;
  Vector3d lever_arm = Vector3d::Zero();  ///< in the accelerometers' axes
};

/// Fits rotation and scale of each window, then one lever arm for all, then each window again. `gravity`: whether the
/// forces contain gravity. `mirrored`: whether R is a rotation with a reflection.
JointFit fit_all(const std::vector<MotionWindow>& windows, const std::vector<CarriedWindow>& carried, bool gravity,
                 bool mirrored);

}  // namespace piste
