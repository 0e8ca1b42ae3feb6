#pragma once
/// By what the gyroscopes, or the accelerometers, of several units differ from their mean, whether one of them is
/// wrong, and their mean without it.

#include <cstddef>
#include <span>
#include <vector>

#include "condition/unit_samples.h"
#include "piste/core/imu_array.h"

namespace piste {

/// A window of epochs, [begin, end), over which differences are compared.
struct UnitWindow {
  std::size_t begin = 0, end = 0;
  double duration = 0;
};

/// The mean of a triad at one epoch.
struct TriadMean {
  Vector3d value = Vector3d::Zero();
  Vector3d added = Vector3d::Zero();  ///< squared density of what missing units add to the noise of their mean
  std::uint8_t missing = 0;           ///< bit i: no unit tells axis i
};

/// A triad of several units, epoch by epoch and window by window.
struct CombinedTriad {
  std::vector<TriadMean> mean;                 ///< of each epoch
  std::vector<bool> whole;                     ///< of each window: every unit told every axis all the time
  std::vector<std::vector<std::uint8_t>> out;  ///< of each unit and epoch: axes without it
  std::vector<std::vector<UnitFault>> why;     ///< where a bit of `out` is set
};

/// Takes the units' mean. The mean over a window of each unit less that of all, r = β + g·u + noise, is followed by a
/// Kalman filter for each unit and axis: an offset β that drifts as the sensor does, and a row g for scale and
/// mounting. Its noise is that of the sensor, or as much as the windows show. A unit is wrong where r leaves the
/// prediction by kWrong sigmas while three units or more tell the axis, and by more than that of any other unit. It is
/// left out from the start of that window, and comes back after kPatience windows within kRight sigmas. Where a unit is
/// left out, for this or because a sample of it says nothing, β and g of the others are taken off their mean, so that
/// it goes on as that of all.
///
/// Where a unit begins late, the differences before it are those that the first minutes with it tell, backwards.
///
/// Of two units that part nobody knows which is wrong: both stay, and what they differ by is learned anew.
/// @pre Units have as many epochs as there are `intervals` [s]; windows follow each other without gaps.
CombinedTriad combine(std::span<const UnitTriad* const> units, std::span<const ImuSensor> sensors, TriadMember triad,
                      const std::vector<double>& intervals, const std::vector<UnitWindow>& windows);

/// Mean of a unit over a window.
Vector3d mean_over(const UnitTriad& unit, const UnitWindow& window, const std::vector<double>& intervals);

/// 1-sigma of the white noise in a series, by the median of its steps less what the steps of `signal` explain, axis by
/// axis. Zero if the series is too short to tell.
Vector3d noise_of(std::span<const Vector3d> series, std::span<const Vector3d> signal);

}  // namespace piste
