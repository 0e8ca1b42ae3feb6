#pragma once
/// The signals of two IMUs after the same filters. Those of the body IMU are at its own sample times; those of the
/// reference are functions of time.

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "condition/spline.h"
#include "piste/core/log.h"

namespace piste {

/// A linear filter that does not change with time, such as a low-pass or a whitening.
using LinearFilter = std::function<std::vector<Vector3d>(std::span<const Vector3d>)>;

/// Filters for rates and forces. `before` and `after`: how many seconds before and after a sample they use.
struct TriadFilters {
  LinearFilter gyro, accel;
  double before = 0, after = 0;
};

/// Mean rate and force over an interval, and the force that a lever arm of a metre along each axis adds.
struct MeanSignal {
  Vector3d gyro, accel;
  Matrix3d lever;  ///< [w']ₓ + [w]ₓ², mean over the interval
};

/// The reference IMU as a function of time: its mean signals over any interval, from cubic splines through the sums of
/// its increments.
class ReferenceIntegrals {
 public:
  explicit ReferenceIntegrals(const std::vector<ImuSample>& imu);

  /// Mean over (t − interval, t]. @pre within [start, end]
  MeanSignal mean(double t, double interval) const;
  double start() const { return time_.front(); }
  double end() const { return time_.back(); }
  /// Whether the IMU has a gap anywhere within [from, to].
  bool silent(double from, double to) const;

 private:
  std::size_t index(double t) const;
  std::vector<double> time_;
  std::vector<Vector3d> angle_, velocity_;
  std::vector<Interval> gaps_;
  std::unique_ptr<Spline> angle_spline_, velocity_spline_;
};

/// The reference IMU after filters: means over the cells of a regular grid, filtered, and interpolated by cubic
/// splines.
class ReferenceGrid {
 public:
  /// Cells of length `step`.
  ReferenceGrid(const ReferenceIntegrals& reference, double step);
  /// The same signals through one more filter.
  ReferenceGrid filtered(const TriadFilters& filters) const;

  struct Value {
    MeanSignal signal, slope;  ///< `slope` is the derivative of `signal` by time
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

/// The axes of a sample that may be used: bit i is axis i.
struct UsableAxes {
  std::uint8_t gyro = 7, accel = 7;
};

/// The body IMU: mean rate and force over the interval before each sample.
struct BodySignals {
  double step = 0;           ///< median interval
  std::vector<double> time;  ///< its own clock
  std::vector<Vector3d> gyro, accel;
  std::vector<UsableAxes> usable;  ///< none in gaps and interpolated rows, none of an axis that is clipped

  explicit BodySignals(const std::vector<ImuSample>& imu);
  /// The same signals through one more filter. Samples into which it mixes unusable ones become unusable.
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
  double gyro_gain = 1, accel_gain = 1;  ///< of the filters for a constant
  double margin = 0;                     ///< time [s] next to a gap or an end of the reference that must not be used
  std::size_t stride = 1;                ///< every stride-th sample has all that the filters let pass
};

/// Both IMUs through one zero-phase low-pass of `cutoff` [Hz].
FilteredPair low_passed(const SignalPair& signals, double cutoff);

}  // namespace piste
