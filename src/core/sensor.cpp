#include "piste/core/sensor.h"

#include <cmath>

namespace piste {

void TriadErrors::set_densities(const Vector3d& densities) {
  noise = densities.norm() / std::sqrt(3.0);
  axes = densities / noise;
}

ImuSensor turned(ImuSensor sensor, const Matrix3d& R) {
  for (TriadErrors* triad : {&sensor.gyro, &sensor.accel}) {
    if (triad->axes != Vector3d::Ones()) triad->axes = (R.cwiseAbs2() * triad->axes.cwiseAbs2()).cwiseSqrt();
  }
  return sensor;
}

}  // namespace piste
