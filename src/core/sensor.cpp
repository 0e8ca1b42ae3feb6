#include "piste/core/sensor.h"

#include <cmath>

namespace piste {
namespace {

double over_axes(const Eigen::Vector3d& densities) { return densities.norm() / std::sqrt(3.0); }

}  // namespace

Eigen::Vector3d TriadErrors::densities() const {
  if (!axes_differ()) return Eigen::Vector3d::Constant(noise);
  return noise / over_axes(axis_noise) * axis_noise;
}

void TriadErrors::set_densities(const Eigen::Vector3d& densities) {
  noise = over_axes(densities);
  axis_noise = densities;
}

ImuSensor turned(ImuSensor sensor, const Eigen::Matrix3d& R) {
  for (TriadErrors ImuSensor::*of : {&ImuSensor::gyro, &ImuSensor::accel}) {
    TriadErrors& triad = sensor.*of;
    if (triad.axes_differ()) triad.axis_noise = (R.cwiseAbs2() * triad.axis_noise.cwiseAbs2()).cwiseSqrt();
  }
  return sensor;
}

}  // namespace piste
