#pragma once
/// An IMU and a receiver as signals that can be asked at any time.

#include <optional>
#include <vector>

#include "piste/core/log.h"
#include "piste/inspect/gnss_health.h"

namespace piste {

/// Integrals of the rows of an IMU since its first one; a row stands for the interval before it.
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
  /// At a time within start and end, linear within a row.
  Value at(double time) const;
  /// Whether there are rows all along.
  bool covers(double begin, double end) const;
  /// Rows within (begin, end] with an axis at a limit that it reaches again and again: they measure nothing.
  std::size_t clipped(double begin, double end) const;

 private:
  void find_clipped(const ImuRecording& imu);

  std::vector<double> time_, clipped_;
  std::vector<Value> value_;
  std::vector<double> gap_ends_;  // sorted
  std::vector<double> gap_starts_;
  double interval_ = 0;
};

/// Velocity of the antenna, in north-east-down: that of the receiver as it is to be read, or what the positions do.
class Track {
 public:
  Track(const GnssRecording& gnss, const GnssHealth& health);

  bool empty() const { return time_.empty(); }
  double start() const { return time_.front(); }
  double end() const { return time_.back(); }
  /// Median interval [s].
  double interval() const { return interval_; }
  /// Linear between fixes; none outside and in gaps.
  std::optional<Vector3d> velocity(double time) const;

 private:
  std::vector<double> time_;
  std::vector<Vector3d> velocity_;
  double interval_ = 0;
};

}  // namespace piste
