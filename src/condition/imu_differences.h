#pragma once
/// Fault detection and exclusion for the gyroscopes, or the accelerometers, of several IMUs: their differences from
/// their mean, and their mean without a faulty one.

#include <cstddef>
#include <span>
#include <vector>

#include "condition/imu_series.h"
#include "piste/core/imu_array.h"

namespace piste {

/// A window of epochs, [begin, end), over which differences are compared.
struct ImuWindow {
  std::size_t begin = 0, end = 0;
  double duration = 0;
};

/// The mean of a triad at one epoch.
struct TriadMean {
  Vector3d value = Vector3d::Zero();
  Vector3d added = Vector3d::Zero();  ///< squared density of the noise that missing IMUs add to the mean
  std::uint8_t missing = 0;           ///< bit i: no IMU measures axis i
};

/// A triad of several IMUs, epoch by epoch and window by window.
struct CombinedTriad {
  std::vector<TriadMean> mean;                 ///< of each epoch
  std::vector<bool> whole;                     ///< of each window: every IMU measured every axis all the time
  std::vector<std::vector<std::uint8_t>> out;  ///< of each IMU and epoch: axes whose mean excludes it
  std::vector<std::vector<ImuFault>> why;      ///< where a bit of `out` is set
};

/// Takes the mean of the IMUs. A Kalman filter for each IMU and axis follows the mean over a window of the IMU less
/// that of all, r = β + g·u + noise. Its states are an offset β, which drifts as the sensor does, and a row g for scale
/// and mounting. Its noise is that of the sensor, or the noise that the windows show if that is larger. An IMU is
/// faulty where r leaves the prediction by kWrong sigmas, and by more than that of any other IMU, while three IMUs or
/// more measure the axis. It is excluded from the start of that window, and returns after kPatience windows within
/// kRight sigmas. While an IMU is excluded, or its sample is not usable, the mean of the others is corrected by their β
/// and g: it continues the mean of all.
///
/// If an IMU begins late, the differences before its start are estimated backwards from the first minutes with it.
///
/// If only two IMUs diverge, the faulty one is not observable: both stay, and their difference is estimated anew.
/// @pre IMUs have as many epochs as there are `intervals` [s]; windows follow each other without gaps.
CombinedTriad combine(std::span<const ImuTriad* const> imus, std::span<const ImuSensor> sensors, TriadMember triad,
                      const std::vector<double>& intervals, const std::vector<ImuWindow>& windows);

/// Mean of an IMU over a window.
Vector3d mean_over(const ImuTriad& unit, const ImuWindow& window, const std::vector<double>& intervals);

/// 1-sigma of the white noise in a series, axis by axis: by the median of its steps after regression on the steps of
/// `signal`. Zero if the series is too short.
Vector3d noise_of(std::span<const Vector3d> series, std::span<const Vector3d> signal);

}  // namespace piste
