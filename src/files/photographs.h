#pragma once
/// Marks as programs of photogrammetry take them: the place of each photograph, and its angles omega, phi and kappa.

#include <string>
#include <vector>

#include "points/placed.h"

namespace piste {

/// Angles of a camera whose point looks along its x axis, with y to the right and z to the bottom of the image.
struct ImageAngles {
  Vector3d angles;  ///< ω, φ, κ [rad]
  Vector3d sigmas;  ///< rad
};

/// ω, φ, κ of R = R_x(ω) R_y(φ) R_z(κ), which turns components of the image (right, up, backwards) into east, north,
/// up at the place (Kraus 2007, Photogrammetry, 2.1.2), and their sigmas. At φ = ± 90° they are not defined.
ImageAngles image_angles(const PlacedPoint& camera);

/// A photograph.
struct PlacedMark {
  std::string name;
  PlacedPoint camera;
};

/// Rows `label, longitude, latitude, altitude, accuracies of x, y, z, omega, phi, kappa, accuracies of these`, as
/// Metashape's import of a reference takes them. Angles in degrees, heights above the ellipsoid.
std::string metashape_text(const std::vector<PlacedMark>& marks);

/// Rows `name, latitude, longitude, altitude, omega, phi, kappa, horizontal and vertical accuracy`, as Pix4D takes
/// them. The horizontal accuracy is the larger one of north and east.
std::string pix4d_text(const std::vector<PlacedMark>& marks);

}  // namespace piste
