#pragma once
/// Choices of a run, shared by conditioning, filter and smoother. SI and radians.

#include <optional>
#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/sensor.h"

namespace piste {

enum class Block : int;  // state_table.h

/// How the rows of an IMU file become increments of the body.
struct ImuConditioning {
  Matrix3d R_bs = Matrix3d::Identity();  ///< sensor components into b: a signed permutation of determinant +1
  bool instantaneous = false;            ///< rows are samples at their time, not means over the interval before it
  double clock_offset = 0;               ///< gps time = t − offset − drift (t − first t)
  double clock_drift = 0;                ///< as a ratio
};

/// Standing still, seen from the sensors.
struct RestOptions {
  bool detect = true;
  double sigma_velocity = 0.01;   ///< of a standing body: a person sways
  double sigma_rate = 0.0034907;  ///< 0.2 deg/s: sway again, and slow turning
  double correlation_time = 8;    ///< of that rate [s]: all that zero rates tell within it counts as one of them
  double interval = 0.5;          ///< time between zero updates [s]
};

struct ConditioningOptions {
  ImuConditioning imu;
  double gyro_range = 0, accel_range = 0;  ///< 0 = unlimited
  Interval span;                           ///< GPS time; {0, 0} = all
  std::vector<Interval> outages;           ///< GNSS withheld here
  RestOptions rest;
};

/// A first-order Gauss-Markov error, per axis.
struct GaussMarkov {
  Vector3d sigma;
  double correlation_time = 0;
};

/// One receiver.
struct GnssOptions {
  std::string name;
  Vector3d lever_arm = Vector3d::Zero();  ///< b → antenna; the start value where it is estimated
  bool use_position = true, use_velocity = true;
  /// Coloured position error along w. Sigmas of the fixes are the total: white = sqrt(total² − drift²), at least
  /// 10 % of the total. One receiver at most may have it.
  std::optional<GaussMarkov> drift;
};

/// One reference attitude.
struct AttitudeOptions {
  std::string name;
  /// Where given, the fixes' error is this process and white noise; else white.
  std::optional<GaussMarkov> drift;
  /// Where given, the boresight changes in the run, by this process about its constant. One reference at most may say
  /// so: there is one IMU and one mount.
  std::optional<GaussMarkov> boresight_drift = std::nullopt;
  /// The white part of the fixes' sigma along w where there is a drift; `with_white_part` finds it.
  Vector3d white = Vector3d::Constant(0.1);
};

/// 1-sigma priors of the blocks that no sensor file knows.
struct Priors {
  double boresight = 0.17;   ///< 10 deg about the start value
  double lever_arm = 0.1;    ///< m, about the configured one
  double gnss_delay = 0.05;  ///< s
};

struct FilterOptions {
  ImuSensor sensor;
  std::vector<GnssOptions> gnss;          ///< one per Log::gnss
  std::vector<AttitudeOptions> attitude;  ///< one per Log::attitude
  std::vector<Block> estimate;            ///< blocks beyond position, velocity and attitude
  RestOptions rest;
  Priors priors;
  double gate = 0.999;        ///< probability of an innovation beyond which it is rejected
  int readmit_after = 5;      ///< rejections in a row after which the filter is held to be wrong, where it may be
  double distrust = 40;       ///< longest time for which a receiver that jumped is not believed [s]
  double magnetic_sigma = 0;  ///< rad of a magnetic heading; 0 = magnetometer unused
  double declination = 0;     ///< rad, east positive

  /// Throws ConfigError on values that no filter can run with.
  void validate() const;
};

/// Where the heading comes from at the start.
struct InitialHeading {
  enum class Source { kAuto, kAttitude, kMagnetometer, kValue };
  Source source = Source::kAuto;
  double value = 0;             ///< rad, for kValue
  double sigma = 0.0349065850;  ///< rad, for kValue: 2 deg
};

enum class SmootherKind { kNone, kRts };

}  // namespace piste
