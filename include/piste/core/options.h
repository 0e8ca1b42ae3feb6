#pragma once
/// Options of a run, which conditioning, filter and smoother share. SI and radians.

#include <optional>
#include <string>
#include <vector>

#include "piste/core/behaviour.h"
#include "piste/core/log.h"
#include "piste/core/sensor.h"

namespace piste {

enum class Block : int;  // state_table.h

/// How the rows of an IMU file are turned into increments in body axes and GPS time.
struct ImuConditioning {
  Matrix3d R_bs = Matrix3d::Identity();  ///< sensor axes into b: a signed permutation of determinant +1
  bool instantaneous = false;            ///< a row is the value at its time, not the mean over the interval before
  double clock_offset = 0;               ///< gps time = t − offset − drift (t − first t)
  double clock_drift = 0;                ///< a ratio: 1e-6 is 1 ppm
};

struct ConditioningOptions {
  ImuConditioning imu;
  double gyro_range = 0, accel_range = 0;  ///< 0 = unlimited
  Interval span;                           ///< GPS time; {0, 0} = all
  std::vector<Interval> outages;           ///< GNSS fixes in them are withheld
  BehaviourOptions behaviour;
};

/// A first-order Gauss-Markov process on three axes.
struct GaussMarkov {
  Vector3d sigma;
  double correlation_time = 0;
};

/// One GNSS receiver.
struct GnssOptions {
  std::string name;
  Vector3d lever_arm = Vector3d::Zero();  ///< p_ba_b; the start value if it is estimated
  bool use_position = true, use_velocity = true;
  /// The coloured part of the position error, along w. The sigma of a fix is the total error, so that the white part is
  /// sqrt(total² − drift²), and at least 10 % of the total. Only one receiver may have a drift.
  std::optional<GaussMarkov> drift = std::nullopt;
  double delay = 0;  ///< the position of a fix with time t is that of t − delay [s]; the start value if it is estimated
  std::optional<double> velocity_delay = std::nullopt;  ///< of its velocity, against t as well; nothing: it is `delay`

  double delay_of_velocity() const { return velocity_delay.value_or(delay); }
};

/// One reference attitude.
struct AttitudeOptions {
  std::string name;
  /// The coloured part of the error, along w. Without it the error is white.
  std::optional<GaussMarkov> drift;
  /// For a flexible mount: in the run the boresight varies about its constant value by this process. Only one reference
  /// may have it, as there is one IMU on one mount.
  std::optional<GaussMarkov> boresight_drift = std::nullopt;
  /// If there is a drift: the white part of the error as a fraction of the fixes' sigma, along w. `with_white_part`
  /// measures it.
  Vector3d white = Vector3d::Constant(0.1);
  double delay = 0;  ///< a fix with time t is that of t − delay [s]; the start value if it is estimated
};

/// 1-sigma priors of the blocks that do not depend on the IMU's sensor file.
struct Priors {
  double boresight = 0.17;       ///< rad: 10 deg about the start value
  double lever_arm = 0.1;        ///< m, about the configured one
  double gnss_delay = 0.05;      ///< s, about the configured one
  double velocity_delay = 0.2;   ///< s, likewise: velocities of phones and receivers were 0.13 to 0.68 s late
  double attitude_delay = 0.02;  ///< s, likewise
};

/// How far, and how fast, a filter may find noise to be other than stated (solve/adaptation.h). The logarithm of the
/// factor of a variance is a Gauss-Markov process about zero, whose 1-sigma is ln `within`.
struct AdaptationOptions {
  double within = 10;  ///< a sigma may be this many times larger or smaller; sensor files were 3 to 50 times off
  /// Correlation time of a source's factor [s]. By the steady state of its Kalman filter a receiver with one fix a
  /// second is then followed within some 20 s, to 10 % of its sigma; one with ten within 5 s, to 6 %.
  double time = 3600;
  /// Of the factors of the IMU's noise [s]. Fixes tell far less of it: likewise, ten a second show it in minutes.
  double imu_time = 36000;
};

/// Options of the filter.
struct FilterOptions {
  ImuSensor sensor;
  std::vector<GnssOptions> gnss;          ///< one per Log::gnss
  std::vector<AttitudeOptions> attitude;  ///< one per Log::attitude
  std::vector<Block> estimate;            ///< blocks beyond position, velocity and attitude
  BehaviourOptions behaviour;
  Priors priors;
  double magnetic_sigma = 0;               ///< 1-sigma of a magnetic heading [rad]; 0 = the magnetometer is not used
  double declination = 0;                  ///< magnetic declination [rad], east positive
  std::optional<AdaptationOptions> adapt;  ///< nothing: all noise is as stated

  /// Whether the run estimates the block.
  bool estimates(Block block) const;
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

enum class SmootherKind { kNone, kRts, kBatch };

}  // namespace piste
