#pragma once
/// The signals of an IMU and of a receiver as functions of time.

#include <optional>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/gnss_health.h"

namespace piste {

/// Integrals of an IMU's rows since the first one. A row is valid for the interval before it.
class ImuIntegral {
 public:
  struct Value {
    Vector3d angle, velocity;
  };
  explicit ImuIntegral(const ImuRecording& imu);

  double start() const { return time_.front(); }
  double end() const { return time_.back(); }
  /// Median interval [s].
  double interval() const { return interval_; }
  /// The integrals at a time, linear within a row. @pre start() ≤ time ≤ end()
  Value at(double time) const;
  /// Whether there is no gap in this time.
  bool covers(double begin, double end) const;
  /// Number of rows within (begin, end] in which an axis is clipped.
  std::size_t clipped(double begin, double end) const;

 private:
  void find_clipped(const ImuRecording& imu);

  std::vector<double> time_, clipped_;
  std::vector<Value> value_;
  std::vector<double> gap_ends_;  // sorted
  std::vector<double> gap_starts_;
  double interval_ = 0;
};

/// Velocity of the antenna in north-east-down: the receiver's velocity, corrected as GnssHealth states, or the
/// derivative of the positions.
class Track {
 public:
  Track(const GnssRecording& gnss, const GnssHealth& health);

  bool empty() const { return time_.empty(); }
  double start() const { return time_.front(); }
  double end() const { return time_.back(); }
  /// Median interval [s].
  double interval() const { return interval_; }
  /// The velocity at a time, linear between fixes. Nothing outside the log and in gaps.
  std::optional<Vector3d> velocity(double time) const;

 private:
  std::vector<double> time_;
  std::vector<Vector3d> velocity_;
  double interval_ = 0;
};

}  // namespace piste
