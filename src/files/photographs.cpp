#include "files/photographs.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "io/csv.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// Turns components along the camera's axes into right, up and backwards of the image.
Matrix3d image_of_camera() { return (Matrix3d() << 0, 1, 0, 0, 0, -1, -1, 0, 0).finished(); }

Matrix3d enu_of_ned() { return (Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished(); }

}  // namespace

ImageAngles image_angles(const PlacedPoint& camera) {
  const Vector3d& euler = camera.navigation.euler;
  const Matrix3d R = enu_of_ned() * from_euler(euler).toRotationMatrix() * image_of_camera().transpose();
  const double omega = std::atan2(-R(1, 2), R(2, 2)), phi = std::asin(std::clamp(R(0, 2), -1.0, 1.0)),
               kappa = std::atan2(-R(0, 1), R(0, 0));
  // The rotation error in the level, and what it does to the angles: each turns about an axis that those before it
  // moved.
  const Matrix3d by_euler = enu_of_ned() * euler_axes(euler);
  const Matrix3d covariance = by_euler * camera.covariance.block<3, 3>(6, 6) * by_euler.transpose();
  const Matrix3d about_x = Eigen::AngleAxisd(omega, Vector3d::UnitX()).toRotationMatrix(),
                 about_y = Eigen::AngleAxisd(phi, Vector3d::UnitY()).toRotationMatrix();
  Matrix3d axes;
  axes << Vector3d::UnitX(), about_x.col(1), (about_x * about_y).col(2);
  const Matrix3d to_angles = axes.inverse();
  return {{omega, phi, kappa}, (to_angles * covariance * to_angles.transpose()).diagonal().cwiseMax(0).cwiseSqrt()};
}

std::string metashape_text(const std::vector<PlacedMark>& marks) {
  std::string text =
      "#Label,Longitude,Latitude,Altitude,Accuracy X,Accuracy Y,Accuracy Z,Omega,Phi,Kappa,Accuracy Omega,Accuracy "
      "Phi,Accuracy Kappa\n";
  for (const PlacedMark& mark : marks) {
    const Geodetic& p = mark.camera.navigation.position;
    const Vector3d sigma = sigmas_of(mark.camera).position;
    const auto [angles, accuracy] = image_angles(mark.camera);
    fmt::format_to(std::back_inserter(text), "{},{:.10f},{:.10f},{:.4f},{:.4f},{:.4f},{:.4f}", csv_cell(mark.name),
                   kDegreesPerRadian * p.longitude, kDegreesPerRadian * p.latitude, p.height, sigma.y(), sigma.x(),
                   sigma.z());
    for (const Vector3d& three : {angles, accuracy}) {
      for (const double angle : three) fmt::format_to(std::back_inserter(text), ",{:.6f}", kDegreesPerRadian * angle);
    }
    text += '\n';
  }
  return text;
}

std::string pix4d_text(const std::vector<PlacedMark>& marks) {
  std::string text = "#imagename,latitude,longitude,altitude,omega,phi,kappa,accuracy horizontal,accuracy vertical\n";
  for (const PlacedMark& mark : marks) {
    const Geodetic& p = mark.camera.navigation.position;
    const Vector3d sigma = sigmas_of(mark.camera).position,
                   angles = kDegreesPerRadian * image_angles(mark.camera).angles;
    fmt::format_to(std::back_inserter(text), "{},{:.10f},{:.10f},{:.4f},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f}\n",
                   csv_cell(mark.name), kDegreesPerRadian * p.latitude, kDegreesPerRadian * p.longitude, p.height,
                   angles.x(), angles.y(), angles.z(), std::max(sigma.x(), sigma.y()), sigma.z());
  }
  return text;
}

}  // namespace piste
