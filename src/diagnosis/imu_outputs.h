#pragma once
/// The outputs of each of several IMUs, from their mean and parities in a log.

#include <Eigen/Core>
#include <vector>

#include "piste/core/imu_array.h"
#include "piste/core/log.h"
#include "piste/core/sensor.h"

namespace piste {

using Outputs = Eigen::Matrix<double, 3, Eigen::Dynamic>;  ///< a column for each window, in b

/// The outputs of one triad in the windows that all IMUs have, at the place of the first.
struct ImuOutputs {
  std::vector<double> time;      ///< of each window [s]
  std::vector<Vector3d> rate;    ///< of the mean IMU in it
  std::vector<Outputs> of_imus;  ///< less their means: offsets are not informative about the mounting
  double duration = 0;           ///< of a window [s]
};

/// The rates with &ImuSensor::gyro, the specific forces with &ImuSensor::accel. `imus` are the sensors that the mean
/// was made of, the first as well. @pre the log has one parity less than `imus`
ImuOutputs imu_outputs(const Log& log, const std::vector<ImuSensor>& imus, TriadMember triad);

}  // namespace piste
