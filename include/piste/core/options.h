#pragma once
/// Options of a run, which conditioning, filter and smoother share. SI and radians.

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "piste/core/behaviour.h"
#include "piste/core/imu_array.h"
#include "piste/core/log.h"
#include "piste/core/sensor.h"
#include "piste/math/so3.h"
#include "piste/math/units.h"

namespace piste {

enum class Block : int;  // state_table.h

/// How the rows of an IMU file are turned into increments in body axes and GPS time.
struct ImuConditioning {
  Matrix3d R_bs = Matrix3d::Identity();  ///< sensor axes into b: a signed permutation of determinant +1
  bool instantaneous = false;            ///< a row is the value at its time, not the mean over the interval before
  double clock_offset = 0;               ///< gps time = t − offset − drift (t − first t)
  double clock_drift = 0;                ///< a ratio: 1e-6 is 1 ppm
};

/// One of several IMUs on a body, whose axes b are those of the first.
struct FusedImuConditioning {
  std::string name;
  ImuConditioning imu;                ///< R_bs is any rotation
  ImuSensor sensor;                   ///< in b
  Vector3d place = Vector3d::Zero();  ///< p_bu_b: from the first to this one
  bool find_place = false;            ///< it is not known: it is estimated from the motion
};

/// The Earth's field with which a magnetometer in the IMU is compared, and how much of its log is used.
struct MagneticConditioning {
  /// Of the World Magnetic Model. The middle of its years: in most places the azimuth of the field changes by less than
  /// 0.2 deg a year.
  double year = 2027.5;
  std::optional<Vector3d> field = std::nullopt;      ///< along north, east, down [µT]; nothing: that of the model
  std::optional<double> declination = std::nullopt;  ///< rad, east positive: the field is turned to this azimuth
  double unit = 1;                                   ///< µT that a 1 in the log stands for
  double interval = 0;                               ///< s between the samples that are used; 0: every row
};

/// s between the samples that a filter uses: what surrounds a magnetometer changes over a second and more.
inline constexpr double kMagneticInterval = 0.1;

struct ConditioningOptions {
  ImuConditioning imu;
  std::vector<FusedImuConditioning> imus = {};  ///< of several IMUs, the first as well; empty for one
  MagneticConditioning magnetic = {};
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

/// The slow part of the error of a receiver's positions, along the local level: a first-order Gauss-Markov process.
struct PositionDrift : GaussMarkov {
  /// Whether `sigma` is a share of the sigma that each fix states, without a unit. The state is then in units of what
  /// was stated over the last minute (SlowLevel), and so follows a receiver whose sigmas change. Else `sigma` is in m.
  bool of_stated = false;
  /// Of a share: most of the white part [m]. What fixes state beyond is slow, as errors of float ambiguities are beside
  /// those of fixed ones.
  double most_white = std::numeric_limits<double>::infinity();

  /// In m.
  PositionDrift(const GaussMarkov& process) : GaussMarkov(process) {}
  /// `share` of the stated sigma, below 1.
  static PositionDrift of_share(const Vector3d& share, double correlation_time) {
    PositionDrift drift({share, correlation_time});
    drift.of_stated = true;
    return drift;
  }

  /// Its 1-sigma [m] where a fix states `sigma`.
  Vector3d sigma_at(const Vector3d& stated) const { return of_stated ? sigma.cwiseProduct(stated).eval() : sigma; }
  /// Follows the sigmas of a log that are multiplied by `factor`.
  void follow(double factor) {
    if (!of_stated) sigma *= factor;
  }
};

/// s that the slow error of a receiver lasts where nothing is known of it: atmosphere and multipath of a minute (Groves
/// 2013, chapter 9).
inline constexpr double kSlowTime = 60;

/// Receivers that may have a slow error, or an antenna that sways, of their own: the first ones of the list.
inline constexpr int kDriftingReceivers = 4;

/// One GNSS receiver.
struct GnssOptions {
  std::string name;
  Vector3d lever_arm = Vector3d::Zero();  ///< p_ba_b; the start value if it is estimated
  bool use_position = true, use_velocity = true;
  /// The slow part of the position error. The sigma of a fix is the total error, so that the white part is
  /// sqrt(total² − drift²). With a drift in m the white part is at least 10 % of the total. Only the first
  /// `kDriftingReceivers` may have one.
  std::optional<PositionDrift> drift = std::nullopt;
  double delay = 0;  ///< the position of a fix with time t is that of t − delay [s]; the start value if it is estimated
  std::optional<double> velocity_delay = std::nullopt;  ///< of its velocity, against t as well; nothing: it is `delay`

  /// The time over which its velocity is a mean, about the velocity's own time [s]; 0: it is of the moment. Receivers
  /// that smooth their velocities show less of a step or a swing than there is.
  double velocity_averaging = 0;

  /// Of an antenna on a helmet or a pack, which moves on the body: its displacement from `lever_arm`, along each body
  /// axis. All axes are equal.
  std::optional<GaussMarkov> lever_arm_sway = std::nullopt;

  /// The user says that its errors are white: innovations may then lower the sigmas of its positions.
  bool white = false;

  double delay_of_velocity() const { return velocity_delay.value_or(delay); }
};

/// Times over which velocities may be means, as programs try them [s]. No longer one may be stated: RecentSteps go back
/// that far.
inline constexpr std::array kAveragingTimes{0.1, 0.2, 0.4, 0.8};

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

/// The carrier of the IMU, if its wheels let it move along its own axis only (model/vehicle.h). The axes v of a vehicle
/// point forward, right and down; those of a bicycle lean with it.
struct VehicleOptions {
  enum class Kind { kCar, kBicycle };
  Kind kind = Kind::kCar;
  /// p_bc_b: the middle between the rear wheels' contact points, or the rear wheel's; the start value of a block.
  Vector3d contact = Vector3d::Zero();
  Vector3d contact_sigma = Vector3d(1.5, 0.7, 0.7);  ///< m: an IMU somewhere between dashboard and boot
  double pitch_centre_sigma = 1.5;  ///< m: springs let a car pitch about a point between its axles; 0 for a bicycle
  std::optional<Quaterniond> mounting =
      std::nullopt;  ///< q_vb; nothing: estimated from the motion (vehicle_mounting.h)
  Vector3d mounting_sigma = Vector3d::Constant(2 * kDegree);  ///< rad, about the axes of v: what an eye can level
  double interval =
      1;  ///< s between two updates: springs and slip are correlated for as long, so that more add no information
  /// Velocity across the vehicle in spite of the wheels: slip and camber. On a drive with RTK it was 0.05 m/s at speeds
  /// of 2 to 16 m/s, in another car 0.03 m/s at up to 33 m/s. Its correlation time was 1 to 5 s.
  GaussMarkov slip{{0.04, 0, 0}, 3};
  Vector3d white = Vector3d(0, 0.02, 0.03);             ///< m/s: its white part
  Vector3d white_by_speed = Vector3d(0, 0.001, 0.007);  ///< rad: its part proportional to the speed
  /// Pitch of a car on its springs against the path of its wheels: by load, humps and dips. On the same drives the
  /// velocity along down was 0.3 deg of the speed, with a correlation time of 1 to 2 s.
  GaussMarkov spring_pitch{{0.4 * kDegree, 0, 0}, 2};
  double dive_sigma = 0.006;  ///< rad/(m/s²): of that pitch by forward force: at 5 m/s² a car dives 1.5 deg
  /// rad/(m/s²): of the slip angle of tyres, by lateral acceleration. That of a car at its limit of some 8 m/s² is 4
  /// deg.
  double cornering_sigma = 0.005;
};

/// Wheel speed: the speed of the contact point of `vehicle` along its forward axis.
struct OdometerOptions {
  double sigma = 0.1;                 ///< m/s, where the log states none: the last digit of 1 km/h is 0.08 m/s
  double scale_sigma = 0.03;          ///< a tyre's radius, by wear, load and pressure
  GaussMarkov slip{{0.01, 0, 0}, 5};  ///< m/s: of the rim against the road, under drive and brake
  bool is_signed = false;             ///< backwards is negative
};

/// Barometer: height with an offset that the weather changes.
struct BarometerOptions {
  double sigma = 0.5;                      ///< m, where the log states none
  GaussMarkov offset{{100, 0, 0}, 36000};  ///< m: the weather's 12 hPa, over some 10 h
};

/// Heading of a baseline of two antennas.
struct DualHeadingOptions {
  Vector3d baseline = Vector3d::UnitX();  ///< in b: its azimuth is the heading
  double sigma = 0.5 * kDegree;           ///< rad, where the log states none
};

/// Magnetometer of the IMU (model/magnetometer.h) [µT].
struct MagnetometerOptions {
  double sigma = 0.5;       ///< white noise of an axis: 0.1 to 0.5 µT by the data sheets of MEMS
  double hard_iron = 30;    ///< prior of the field of the carrier: phones, helmets and cars have 10 to 50
  double soft_iron = 0.05;  ///< prior of each element of S, with scale and misalignment of the sensor
  /// The field of steel, cables and rock near the path: 1 µT is some 3 deg of heading in Central Europe.
  GaussMarkov disturbance{{1, 1, 1}, 10};
};

/// 1-sigma priors of the blocks that do not depend on the IMU's sensor file.
struct Priors {
  double boresight = 0.17;       ///< rad: 10 deg about the start value
  double lever_arm = 0.1;        ///< m, about the configured one
  double gnss_delay = 0.05;      ///< s, about the configured one
  double velocity_delay = 0.2;   ///< s, likewise: velocities of phones and receivers were 0.13 to 0.68 s late
  double attitude_delay = 0.02;  ///< s, likewise
  double clock_drift = 1e-4;     ///< a ratio, about the configured one: loggers were 14 to 310 ppm off
};

/// How far, and how fast, an adaptive filter may change the stated noise (filter/adaptation.h). The logarithm of the
/// factor of a variance is a Gauss-Markov process about zero, whose 1-sigma is ln `within`.
struct AdaptationOptions {
  double within = 10;  ///< a sigma may be this many times larger or smaller; sensor files were 3 to 50 times off
  /// Correlation time of a source's factor [s]. By the steady state of its Kalman filter, a receiver of 1 Hz is then
  /// followed within some 20 s, to 10 % of its sigma. One of 10 Hz is followed within 5 s, to 6 %.
  double time = 3600;
  /// Correlation time of the factors of the IMU's noise [s]. Fixes are far less informative about it: at 10 Hz it takes
  /// minutes.
  double imu_time = 36000;
};

/// Options of the filter.
struct FilterOptions {
  ImuSensor sensor;                       ///< of several IMUs that of their mean (mean_sensor())
  std::vector<ImuSensor> imus = {};       ///< of several IMUs; empty for one
  std::vector<Matrix3d> unit_axes = {};   ///< of each, from its axes to those of the first; empty: all have the same
  std::vector<GnssOptions> gnss;          ///< one per Log::gnss
  std::vector<AttitudeOptions> attitude;  ///< one per Log::attitude
  std::vector<Block> estimate;            ///< blocks beyond position, velocity and attitude
  BehaviourOptions behaviour;
  Priors priors;
  /// Time from which a drift of the IMU's clock counts [s]; nothing: from the filter's start.
  std::optional<double> clock_from = std::nullopt;
  std::optional<VehicleOptions> vehicle = std::nullopt;            ///< nothing: the body moves as it likes
  std::optional<OdometerOptions> odometer = std::nullopt;          ///< of Log::speed; needs a vehicle
  std::optional<BarometerOptions> barometer = std::nullopt;        ///< of Log::height
  std::optional<DualHeadingOptions> heading = std::nullopt;        ///< of Log::heading
  std::optional<MagnetometerOptions> magnetometer = std::nullopt;  ///< of Log::magnetic; nothing: it is not used
  std::optional<AdaptationOptions> adapt;                          ///< nothing: all noise is as stated

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

/// The cost of wrong fixes.
enum class BatchLoss {
  kTruncated,  ///< no more than a fix at the bound
  kBarron,     ///< ever less with its size: Barron 2019 with α = −2 (Geman and McClure), scaled by the bound
  kSquared     ///< in full: every fix that the filter used is taken to be right
};

/// How a batch is solved (batch/batch.h).
struct BatchOptions {
  BatchLoss loss = BatchLoss::kTruncated;
  /// Probability of a right fix within the bound, by its number of rows: chi-squared.
  double bound = 0.999;
  /// Longest time between nodes [s]: over more, preintegration is not linear in the errors of the IMU.
  double longest_interval = 1;
  /// Most relinearisations of the whole run about its solution. Two are enough if the filter did not diverge.
  int most_rounds = 10;
  /// The solution has converged when a relinearisation moves it by less: half the squared norm, in sigmas, of all
  /// unknowns of a thousand nodes together. The next relinearisation would move it by a small part of that.
  double tolerance = 5e-3;
};

}  // namespace piste
