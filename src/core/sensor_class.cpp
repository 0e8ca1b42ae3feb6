#include "piste/core/sensor_class.h"

#include <algorithm>
#include <array>
#include <limits>

#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kMicroG = 1e-6 * kStandardGravity, kAny = std::numeric_limits<double>::infinity();
constexpr double kPerG = kDegree / kStandardGravity;  // deg/s/g

// From the best to the worst, which has no bound.
constexpr std::array kClasses = std::to_array<SensorClass>({
    {"tactical", 0.0025 * kDegree, 120 * kMicroG, 100e-6, 0.002 * kPerG},
    {"industrial", 0.012 * kDegree, 120 * kMicroG, 1000e-6, 0.01 * kPerG},
    {"consumer", kAny, kAny, 3000e-6, 0.1 * kPerG},
});

}  // namespace

const SensorClass& class_of(const ImuSensor& sensor) {
  return *std::ranges::find_if(kClasses, [&](const SensorClass& c) {
    return sensor.gyro.noise <= c.gyro_noise && sensor.accel.noise <= c.accel_noise;
  });
}

ImuSensor with_errors_of_class(ImuSensor sensor) {
  const SensorClass& own = class_of(sensor);
  for (TriadErrors* triad : {&sensor.gyro, &sensor.accel}) {
    if (!triad->cross_axis) triad->cross_axis = own.cross_axis;
  }
  if (!sensor.gyro_g_sensitivity) sensor.gyro_g_sensitivity = own.gyro_g_sensitivity;
  return sensor;
}

}  // namespace piste
