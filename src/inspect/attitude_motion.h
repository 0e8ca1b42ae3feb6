#pragma once
/// The rotations of an attitude log and of an IMU over the same intervals.

#include <vector>

#include "log_signals.h"
#include "piste/core/log.h"

namespace piste {

/// An attitude log as gyroscope data: the rotations from one attitude to the next, in the reference axes, as the
/// increments of IMU samples without forces. Attitudes closer than 0.1 s are skipped, so that their noise does not hide
/// the motion. Gaps are left out.
std::vector<ImuSample> turns_of(const AttitudeRecording& attitude);

/// The rotation of an IMU as a function of time, in its own axes.
class GyroTurns {
 public:
  explicit GyroTurns(const ImuRecording& imu);

  /// The rotation vector from `begin` to `end`. @pre covers(begin, end)
  Vector3d turn(double begin, double end) const { return so3_log(at(begin).conjugate() * at(end)); }
  /// Whether there is no gap in this time.
  bool covers(double begin, double end) const { return integral_.covers(begin, end); }
  /// Interval of the rows [s].
  double interval() const { return integral_.interval(); }
  /// The rows as increments, without forces.
  const std::vector<ImuSample>& samples() const { return samples_; }

 private:
  Quaterniond at(double time) const;

  ImuIntegral integral_;
  std::vector<ImuSample> samples_;
  std::vector<Quaterniond> attitude_;  // at the end of each sample
};

}  // namespace piste
