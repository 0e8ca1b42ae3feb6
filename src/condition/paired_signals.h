#pragma once
/// The signals of two IMUs, filtered alike: the body IMU's at its own samples, the reference's as functions of time.

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "condition/spline.h"
#include "piste/core/log.h"

namespace piste {

/// Any linear filter that does not change with time: low-pass, whitening.
using LinearFilter = std::function<std::vector<Vector3d>(std::span<const Vector3d>)>;

/// What rates and forces go through, and how far it smears: seconds back and ahead.
struct TriadFilters {
  LinearFilter gyro, accel;
  double before = 0, after = 0;
};

/// Mean rate and force over one interval, and what a lever arm of a metre along each axis adds to the force.
struct MeanSignal {
  Vector3d gyro, accel;
  Matrix3d lever;  ///< [w']ₓ + [w]ₓ², mean over the interval
};

/// A reference IMU as integrals over any interval, from cubic splines through its summed increments.
class ReferenceIntegrals {
 public:
  explicit ReferenceIntegrals(const std::vector<ImuSample>& imu);

  /// Mean over (t − interval, t]. @pre within [start, end]
  MeanSignal mean(double t, double interval) const;
  double start() const { return time_.front(); }
  double end() const { return time_.back(); }
  /// Whether the IMU is silent anywhere within [from, to].
  bool silent(double from, double to) const;

 private:
  std::size_t index(double t) const;
  std::vector<double> time_;
  std::vector<Vector3d> angle_, velocity_;
  std::vector<Interval> gaps_;
  std::unique_ptr<Spline> angle_spline_, velocity_spline_;
};

/// Means over cells of a regular grid, filtered, and interpolated by cubic splines.
class ReferenceGrid {
 public:
  /// Cells of length `step`.
  ReferenceGrid(const ReferenceIntegrals& reference, double step);
  /// The same signals through one more filter.
  ReferenceGrid filtered(const TriadFilters& filters) const;

  struct Value {
    MeanSignal signal, slope;  ///< and its derivative by time
  };
  /// Mean over (t − step, t]. @pre within the grid
  Value at(double t) const;
  bool contains(double t) const { return t >= time_->front() && t <= time_->back(); }

 private:
  static constexpr int kChannels = 5;  // gyro, accel, the columns of lever
  ReferenceGrid(std::shared_ptr<const std::vector<double>> time, std::array<std::vector<Vector3d>, kChannels> values);
  void make_splines();
  std::shared_ptr<const std::vector<double>> time_;
  std::shared_ptr<const std::array<std::vector<Vector3d>, kChannels>> values_;
  std::vector<Spline> splines_;
};

/// Axes of gyroscope and accelerometer that a sample may be judged by: bit i is axis i.
struct UsableAxes {
  std::uint8_t gyro = 7, accel = 7;
};

/// The body IMU: mean rate and force over the interval before each sample.
struct BodySignals {
  double step = 0;           ///< median interval
  std::vector<double> time;  ///< its own clock
  std::vector<Vector3d> gyro, accel;
  std::vector<UsableAxes> usable;  ///< none in gaps, and none of an axis that is clipped

  explicit BodySignals(const std::vector<ImuSample>& imu);
  /// The same signals through one more filter. What it smears is unusable.
  BodySignals filtered(const TriadFilters& filters) const;
};

/// Both IMUs before any filter.
struct SignalPair {
  BodySignals body;
  ReferenceIntegrals integrals;  ///< of the reference
  ReferenceGrid reference;       ///< its means over intervals as long as those of the body IMU

  SignalPair(const std::vector<ImuSample>& body_imu, const std::vector<ImuSample>& reference_imu);
};

/// Both IMUs after the same filters.
struct FilteredPair {
  BodySignals body;
  ReferenceGrid reference;
  double gyro_gain = 1, accel_gain = 1;  ///< with which the filters pass a constant
  double margin = 0;                     ///< [s] beside a gap or an end of the reference that the filters spoil
  std::size_t stride = 1;                ///< every stride-th sample holds all that the filters let through
};

/// Both IMUs through one zero-phase low-pass of `cutoff` [Hz].
FilteredPair low_passed(const SignalPair& signals, double cutoff);

}  // namespace piste
