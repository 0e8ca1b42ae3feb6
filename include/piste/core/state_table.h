#pragma once
/// The one table of state blocks. Its row for a block has the block's name and unit, its place in an estimate, its
/// prior or its process, and what observes it. Error state, filter, configuration keys, file columns, plots and tests
/// read this table. A new block is therefore a name in `Block`, a member of `Estimate`, a row of `kBlocks`, and the
/// Jacobians of the models that depend on it.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "piste/core/options.h"
#include "piste/math/earth.h"
#include "piste/math/so3.h"
#include "piste/math/units.h"

namespace piste {

/// Kinds of errors of an IMU that parities have: bias, drift and scale of gyroscopes and accelerometers.
inline constexpr int kImuErrors = 6, kParityBlocks = kImuErrors * kMostParities;
/// Slow errors of receivers beyond kGnssPositionDrift: of each one in units of its sigmas, of all but the first in m.
inline constexpr int kReceiverDrifts = 2 * kDriftingReceivers - 1;
/// These, and the antennas that sway.
inline constexpr int kReceiverErrors = kReceiverDrifts + kDriftingReceivers;

enum class Block : int {
  kPosition,
  kVelocity,
  kAttitude,
  kGyroBias,
  kAccelBias,
  kGyroDrift,
  kAccelDrift,
  kGyroScale,
  kAccelScale,
  kGyroCrossAxis,  ///< see model/imu_error_model.h, also for the next two
  kAccelCrossAxis,
  kGyroGSensitivity,
  kBoresight,
  kLeverArm,
  kGnssPositionDrift,
  kGnssDelay,
  kVelocityDelay,
  kAttitudeDelay,
  kClockDrift,
  kAttitudeDrift,
  kBoresightDrift,
  kVehicleMounting,
  kVehicleContact,
  kPitchCentre,
  kDive,
  kSpringPitch,
  kSideSlip,
  kCornering,
  kWheelSlip,
  kOdometerScale,
  kBarometerOffset,
  kHardIron,
  kSoftIronX,
  kSoftIronY,
  kSoftIronZ,
  kMagneticDisturbance,
  kFirstParity,  ///< of several IMUs: for each parity the kinds from kGyroBias to kAccelScale, see parity_block()
  kFirstReceiverDrift = kFirstParity + kParityBlocks,          ///< see position_drift_block()
  kFirstLeverArmSway = kFirstReceiverDrift + kReceiverDrifts,  ///< see lever_arm_sway_block()
};

/// The estimated state at one instant: a value for every block. Its error is defined in estimate.h.
struct Estimate {
  Quaterniond q_wb = Quaterniond::Identity();
  Vector3d v_wb = Vector3d::Zero();
  Vector3d p_wb = Vector3d::Zero();
  Vector3d gyro_bias = Vector3d::Zero();
  Vector3d accel_bias = Vector3d::Zero();
  Vector3d gyro_drift = Vector3d::Zero();
  Vector3d accel_drift = Vector3d::Zero();
  Vector3d gyro_scale = Vector3d::Zero();
  Vector3d accel_scale = Vector3d::Zero();
  /// Off-diagonal elements of the matrix by which a triad measures: of the gyroscopes, xy xz yx yz zx zy; of the
  /// accelerometers, which define the axes of the body, yx zx zy. Then the gyroscopes' response to specific force, by
  /// rows.
  Eigen::Matrix<double, 6, 1> gyro_cross_axis = Eigen::Matrix<double, 6, 1>::Zero();
  Vector3d accel_cross_axis = Vector3d::Zero();
  Eigen::Matrix<double, 9, 1> gyro_g_sensitivity = Eigen::Matrix<double, 9, 1>::Zero();
  Quaterniond q_rb = Quaterniond::Identity();  ///< boresight: b components into r
  Vector3d lever_arm = Vector3d::Zero();       ///< p_ba_b
  Vector3d gnss_position_drift = Vector3d::Zero();
  double gnss_delay = 0;      ///< the position of a fix with time t is that of t − gnss_delay
  double velocity_delay = 0;  ///< and its velocity that of t − velocity_delay
  double attitude_delay = 0;  ///< a reference attitude with time t is that of t − attitude_delay
  double clock_drift = 0;     ///< of the IMU: each delay less clock_drift (t − `clock_from`); a ratio
  Vector3d attitude_drift = Vector3d::Zero();   ///< of the reference attitude: rotation vector in n
  Vector3d boresight_drift = Vector3d::Zero();  ///< of a flexible mount: Exp(drift) R_rb, in r
  Quaterniond q_vb = Quaterniond::Identity();   ///< mounting in a vehicle: b components into v (model/vehicle.h)
  Vector3d vehicle_contact = Vector3d::Zero();  ///< p_bc_b: where the wheels allow no sideways motion
  double pitch_centre = 0;                      ///< where a pitching body does not move up and down, before c
  double dive = 0;                              ///< pitch on the springs by forward force [rad/(m/s²)]
  double spring_pitch = 0;                      ///< the remainder of that pitch [rad]
  double side_slip = 0;                         ///< velocity to the right in spite of the wheels
  double wheel_slip = 0;                        ///< and of a wheel's rim against the road
  double cornering = 0;                         ///< slip angle by lateral acceleration [rad/(m/s²)]
  double odometer_scale = 0;                    ///< odometer = (1 + scale) speed
  double barometer_offset = 0;                  ///< barometer = height + offset
  /// Of a magnetometer [µT] (model/magnetometer.h): the hard iron of the carrier; its soft iron, a row for each axis;
  /// and the disturbance of the Earth's field by the surroundings, along n.
  Vector3d hard_iron = Vector3d::Zero();
  Vector3d soft_iron_x = Vector3d::Zero(), soft_iron_y = Vector3d::Zero(), soft_iron_z = Vector3d::Zero();
  Vector3d magnetic_disturbance = Vector3d::Zero();
  /// The parity errors of several IMUs, parity by parity (core/imu_array.h).
  std::array<Vector3d, kParityBlocks> parity = [] {
    std::array<Vector3d, kParityBlocks> none;
    none.fill(Vector3d::Zero());
    return none;
  }();
  /// Slow errors of receivers, as position_drift_block() has them, and after them how far antennas sway, in b.
  std::array<Vector3d, kReceiverErrors> receiver = [] {
    std::array<Vector3d, kReceiverErrors> none;
    none.fill(Vector3d::Zero());
    return none;
  }();

  Matrix3d R_wb() const { return q_wb.toRotationMatrix(); }
  Matrix3d R_rb() const { return q_rb.toRotationMatrix(); }
};

/// How a block changes in a run: each axis follows the process `law`, with its variances multiplied by `weight`.
struct BlockProcess {
  DriftProcess law;
  Vector3d weight = Vector3d::Ones();
};

/// An element of Estimate::parity.
struct ParityMember {
  std::size_t place;
};

/// An element of Estimate::receiver.
struct ReceiverMember {
  std::size_t place;
};

/// The member of Estimate that holds a block: one, three, six or nine values, or a rotation.
using BlockMember =
    std::variant<Vector3d Estimate::*, double Estimate::*, Quaterniond Estimate::*, ParityMember, ReceiverMember,
                 Eigen::Matrix<double, 6, 1> Estimate::*, Eigen::Matrix<double, 9, 1> Estimate::*>;

/// The largest size of a block, and a number for each of its elements, or for as many as it has.
inline constexpr int kLargestBlock = 9;
using BlockValues = Eigen::Matrix<double, kLargestBlock, 1>;

/// One row of the table. What depends on a run's sensors and sources is a function of its options.
struct BlockInfo {
  Block block;
  std::string_view name;
  int size;
  std::string_view unit;  ///< in files and plots
  double factor;          ///< from SI and radians to that unit
  std::array<std::string_view, kLargestBlock> axes;
  BlockMember member;
  /// Of a block that is constant in a run: its 1-sigma at the start. Null for a process, and for the navigation blocks,
  /// whose sigmas the start gives.
  BlockValues (*prior)(const FilterOptions&) = nullptr;
  /// Of a block that changes in a run: its process, or nothing if this run has no such process. Null for a constant.
  std::optional<BlockProcess> (*process)(const FilterOptions&) = nullptr;
  /// Whether the run has a source that observes the block. Null if every run has one.
  bool (*observed)(const FilterOptions&) = nullptr;
  std::string_view needs = {};  ///< that source, in words for the user
  /// Whether the block is estimated without being named in `estimate`, wherever the run has its process, or what
  /// observes it. This is so for errors that the options of a source state.
  bool implied = false;
};

namespace blocks {

using Axes = std::array<std::string_view, kLargestBlock>;
inline constexpr Axes kLocal{"north", "east", "down"}, kBody{"x", "y", "z"};

inline BlockValues alike(double sigma) { return BlockValues::Constant(sigma); }
inline BlockValues of_axes(const Vector3d& sigma) {
  return (BlockValues() << sigma, BlockValues::Zero().tail<6>()).finished();
}

inline std::optional<BlockProcess> drift(const TriadErrors& triad) {
  if (triad.drift.kind == DriftProcess::Kind::kNone) return std::nullopt;
  return BlockProcess{triad.drift};
}

inline bool some_velocity(const FilterOptions& o) {
  return std::any_of(o.gnss.begin(), o.gnss.end(), [](const GnssOptions& g) { return g.use_velocity; });
}

/// The process of the coloured error `member` of a source, if the run has the source.
template <class Source>
std::optional<BlockProcess> of_source(const std::optional<Source>& source, GaussMarkov Source::*member) {
  if (!source) return std::nullopt;
  const GaussMarkov& error = *source.*member;
  return BlockProcess{{DriftProcess::Kind::kGaussMarkov, 1, error.correlation_time, 0}, error.sigma.cwiseAbs2()};
}

inline bool in_vehicle(const FilterOptions& o) { return o.vehicle.has_value(); }
inline bool with_magnetometer(const FilterOptions& o) { return o.magnetometer.has_value(); }
inline BlockValues soft_iron(const FilterOptions& o) { return alike(o.magnetometer ? o.magnetometer->soft_iron : 0); }

/// The slow error of a receiver, if it has one that is, or is not, in units of its sigmas.
template <std::size_t Receiver, bool kOfStated>
std::optional<BlockProcess> position_drift(const FilterOptions& o) {
  if (o.gnss.size() <= Receiver) return std::nullopt;
  const std::optional<PositionDrift>& drift = o.gnss[Receiver].drift;
  if (!drift || drift->of_stated != kOfStated) return std::nullopt;
  return BlockProcess{{DriftProcess::Kind::kGaussMarkov, 1, drift->correlation_time, 0}, drift->sigma.cwiseAbs2()};
}

/// By how much the antenna of a receiver is away from its place, if it sways.
template <std::size_t Receiver>
std::optional<BlockProcess> lever_arm_sway(const FilterOptions& o) {
  if (o.gnss.size() <= Receiver || !o.gnss[Receiver].lever_arm_sway) return std::nullopt;
  const GaussMarkov& sway = *o.gnss[Receiver].lever_arm_sway;
  return BlockProcess{{DriftProcess::Kind::kGaussMarkov, 1, sway.correlation_time, 0}, sway.sigma.cwiseAbs2()};
}

/// The process of the coloured error `member`, of the last of `sources` that has one.
template <class Source>
std::optional<BlockProcess> coloured(const std::vector<Source>& sources, std::optional<GaussMarkov> Source::*member) {
  std::optional<BlockProcess> process;
  for (const Source& source : sources) {
    if (!(source.*member)) continue;
    const GaussMarkov& error = *(source.*member);
    process = {{DriftProcess::Kind::kGaussMarkov, 1, error.correlation_time, 0}, error.sigma.cwiseAbs2()};
  }
  return process;
}

}  // namespace blocks

/// The rows that are written by hand.
inline constexpr auto kWrittenBlocks = std::to_array<BlockInfo>({
    {.block = Block::kPosition,
     .name = "position",
     .size = 3,
     .unit = "m",
     .factor = 1,
     .axes = blocks::kLocal,
     .member = &Estimate::p_wb},
    {.block = Block::kVelocity,
     .name = "velocity",
     .size = 3,
     .unit = "m/s",
     .factor = 1,
     .axes = blocks::kLocal,
     .member = &Estimate::v_wb},
    {.block = Block::kAttitude,
     .name = "attitude",
     .size = 3,
     .unit = "deg",
     .factor = kDegreesPerRadian,
     .axes = blocks::kLocal,
     .member = &Estimate::q_wb},
    {.block = Block::kGyroBias,
     .name = "gyro_bias",
     .size = 3,
     .unit = "deg/s",
     .factor = kDegreesPerRadian,
     .axes = blocks::kBody,
     .member = &Estimate::gyro_bias,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.sensor.gyro.bias); }},
    {.block = Block::kAccelBias,
     .name = "accel_bias",
     .size = 3,
     .unit = "m/s^2",
     .factor = 1,
     .axes = blocks::kBody,
     .member = &Estimate::accel_bias,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.sensor.accel.bias); }},
    {.block = Block::kGyroDrift,
     .name = "gyro_drift",
     .size = 3,
     .unit = "deg/s",
     .factor = kDegreesPerRadian,
     .axes = blocks::kBody,
     .member = &Estimate::gyro_drift,
     .process = [](const FilterOptions& o) { return blocks::drift(o.sensor.gyro); }},
    {.block = Block::kAccelDrift,
     .name = "accel_drift",
     .size = 3,
     .unit = "m/s^2",
     .factor = 1,
     .axes = blocks::kBody,
     .member = &Estimate::accel_drift,
     .process = [](const FilterOptions& o) { return blocks::drift(o.sensor.accel); }},
    {.block = Block::kGyroScale,
     .name = "gyro_scale",
     .size = 3,
     .unit = "ppm",
     .factor = 1e6,
     .axes = blocks::kBody,
     .member = &Estimate::gyro_scale,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.sensor.gyro.scale); }},
    {.block = Block::kAccelScale,
     .name = "accel_scale",
     .size = 3,
     .unit = "ppm",
     .factor = 1e6,
     .axes = blocks::kBody,
     .member = &Estimate::accel_scale,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.sensor.accel.scale); }},
    {.block = Block::kGyroCrossAxis,
     .name = "gyro_cross_axis",
     .size = 6,
     .unit = "ppm",
     .factor = 1e6,
     .axes = {"xy", "xz", "yx", "yz", "zx", "zy"},
     .member = &Estimate::gyro_cross_axis,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.sensor.gyro.cross_axis.value_or(0)); }},
    {.block = Block::kAccelCrossAxis,
     .name = "accel_cross_axis",
     .size = 3,
     .unit = "ppm",
     .factor = 1e6,
     .axes = {"yx", "zx", "zy"},
     .member = &Estimate::accel_cross_axis,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.sensor.accel.cross_axis.value_or(0)); }},
    {.block = Block::kGyroGSensitivity,
     .name = "gyro_g_sensitivity",
     .size = 9,
     .unit = "deg/s/g",
     .factor = kDegreesPerRadian * kStandardGravity,
     .axes = {"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"},
     .member = &Estimate::gyro_g_sensitivity,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.sensor.gyro_g_sensitivity.value_or(0)); }},
    {.block = Block::kBoresight,
     .name = "boresight",
     .size = 3,
     .unit = "deg",
     .factor = kDegreesPerRadian,
     .axes = {"roll", "pitch", "heading"},
     .member = &Estimate::q_rb,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.priors.boresight); },
     .observed = [](const FilterOptions& o) { return !o.attitude.empty(); },
     .needs = "an `attitude:` source"},
    {.block = Block::kLeverArm,
     .name = "lever_arm",
     .size = 3,
     .unit = "m",
     .factor = 1,
     .axes = blocks::kBody,
     .member = &Estimate::lever_arm,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.priors.lever_arm); },
     .observed = [](const FilterOptions& o) { return !o.gnss.empty(); },
     .needs = "a `gnss:` source"},
    {.block = Block::kGnssPositionDrift,
     .name = "gnss_position_drift",
     .size = 3,
     .unit = "m",
     .factor = 1,
     .axes = blocks::kLocal,
     .member = &Estimate::gnss_position_drift,
     .process = blocks::position_drift<0, false>,
     .needs = "a `gnss:` source with a drift in metres, the first of the list",
     .implied = true},
    {.block = Block::kGnssDelay,
     .name = "gnss_delay",
     .size = 1,
     .unit = "s",
     .factor = 1,
     .axes = {"t", "", ""},
     .member = &Estimate::gnss_delay,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.priors.gnss_delay); },
     .observed = [](const FilterOptions& o) { return !o.gnss.empty(); },
     .needs = "a `gnss:` source"},
    {.block = Block::kVelocityDelay,
     .name = "velocity_delay",
     .size = 1,
     .unit = "s",
     .factor = 1,
     .axes = {"t", "", ""},
     .member = &Estimate::velocity_delay,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.priors.velocity_delay); },
     .observed = [](const FilterOptions& o) { return blocks::some_velocity(o); },
     .needs = "a `gnss:` source whose velocities are used"},
    {.block = Block::kAttitudeDelay,
     .name = "attitude_delay",
     .size = 1,
     .unit = "s",
     .factor = 1,
     .axes = {"t", "", ""},
     .member = &Estimate::attitude_delay,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.priors.attitude_delay); },
     .observed = [](const FilterOptions& o) { return !o.attitude.empty(); },
     .needs = "an `attitude:` source"},
    {.block = Block::kClockDrift,
     .name = "clock_drift",
     .size = 1,
     .unit = "ppm",
     .factor = 1e6,
     .axes = {"t", "", ""},
     .member = &Estimate::clock_drift,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.priors.clock_drift); },
     .observed = [](const FilterOptions& o) { return !o.gnss.empty() || !o.attitude.empty(); },
     .needs = "a `gnss:` or an `attitude:` source"},
    {.block = Block::kAttitudeDrift,
     .name = "attitude_drift",
     .size = 3,
     .unit = "deg",
     .factor = kDegreesPerRadian,
     .axes = blocks::kLocal,
     .member = &Estimate::attitude_drift,
     .process = [](const FilterOptions& o) { return blocks::coloured(o.attitude, &AttitudeOptions::drift); },
     .needs = "an `attitude:` source whose errors have a `correlation_time:`",
     .implied = true},
    {.block = Block::kBoresightDrift,
     .name = "boresight_drift",
     .size = 3,
     .unit = "deg",
     .factor = kDegreesPerRadian,
     .axes = blocks::kBody,
     .member = &Estimate::boresight_drift,
     .process = [](const FilterOptions& o) { return blocks::coloured(o.attitude, &AttitudeOptions::boresight_drift); },
     .needs = "an `attitude:` source with `boresight: {sigma, correlation_time}`",
     .implied = true},
    {.block = Block::kVehicleMounting,
     .name = "vehicle_mounting",
     .size = 3,
     .unit = "deg",
     .factor = kDegreesPerRadian,
     .axes = {"roll", "pitch", "heading"},
     .member = &Estimate::q_vb,
     .prior =
         [](const FilterOptions& o) {
           return blocks::of_axes(o.vehicle ? o.vehicle->mounting_sigma : Vector3d(Vector3d::Zero()));
         },
     .observed = blocks::in_vehicle,
     .needs = "the key `vehicle:`",
     .implied = true},
    {.block = Block::kVehicleContact,
     .name = "vehicle_contact",
     .size = 3,
     .unit = "m",
     .factor = 1,
     .axes = blocks::kBody,
     .member = &Estimate::vehicle_contact,
     .prior =
         [](const FilterOptions& o) {
           return blocks::of_axes(o.vehicle ? o.vehicle->contact_sigma : Vector3d(Vector3d::Zero()));
         },
     .observed = blocks::in_vehicle,
     .needs = "the key `vehicle:`",
     .implied = true},
    {.block = Block::kPitchCentre,
     .name = "pitch_centre",
     .size = 1,
     .unit = "m",
     .factor = 1,
     .axes = {"forward", "", ""},
     .member = &Estimate::pitch_centre,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.vehicle ? o.vehicle->pitch_centre_sigma : 0); },
     .observed = blocks::in_vehicle,
     .needs = "the key `vehicle:`",
     .implied = true},
    {.block = Block::kDive,
     .name = "dive",
     .size = 1,
     .unit = "deg/(m/s^2)",
     .factor = kDegreesPerRadian,
     .axes = {"pitch", "", ""},
     .member = &Estimate::dive,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.vehicle ? o.vehicle->dive_sigma : 0); },
     .observed = blocks::in_vehicle,
     .needs = "the key `vehicle:`",
     .implied = true},
    {.block = Block::kSpringPitch,
     .name = "spring_pitch",
     .size = 1,
     .unit = "deg",
     .factor = kDegreesPerRadian,
     .axes = {"pitch", "", ""},
     .member = &Estimate::spring_pitch,
     .process = [](const FilterOptions& o) { return blocks::of_source(o.vehicle, &VehicleOptions::spring_pitch); },
     .needs = "the key `vehicle:`",
     .implied = true},
    {.block = Block::kSideSlip,
     .name = "side_slip",
     .size = 1,
     .unit = "m/s",
     .factor = 1,
     .axes = {"right", "", ""},
     .member = &Estimate::side_slip,
     .process = [](const FilterOptions& o) { return blocks::of_source(o.vehicle, &VehicleOptions::slip); },
     .needs = "the key `vehicle:`",
     .implied = true},
    {.block = Block::kCornering,
     .name = "cornering",
     .size = 1,
     .unit = "deg/(m/s^2)",
     .factor = kDegreesPerRadian,
     .axes = {"right", "", ""},
     .member = &Estimate::cornering,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.vehicle ? o.vehicle->cornering_sigma : 0); },
     .observed = blocks::in_vehicle,
     .needs = "the key `vehicle:`",
     .implied = true},
    {.block = Block::kWheelSlip,
     .name = "wheel_slip",
     .size = 1,
     .unit = "m/s",
     .factor = 1,
     .axes = {"forward", "", ""},
     .member = &Estimate::wheel_slip,
     .process = [](const FilterOptions& o) { return blocks::of_source(o.odometer, &OdometerOptions::slip); },
     .needs = "the key `odometer:`",
     .implied = true},
    {.block = Block::kOdometerScale,
     .name = "odometer_scale",
     .size = 1,
     .unit = "ppm",
     .factor = 1e6,
     .axes = {"forward", "", ""},
     .member = &Estimate::odometer_scale,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.odometer ? o.odometer->scale_sigma : 0); },
     .observed = [](const FilterOptions& o) { return o.odometer.has_value(); },
     .needs = "the key `odometer:`",
     .implied = true},
    {.block = Block::kBarometerOffset,
     .name = "barometer_offset",
     .size = 1,
     .unit = "m",
     .factor = 1,
     .axes = {"up", "", ""},
     .member = &Estimate::barometer_offset,
     .process = [](const FilterOptions& o) { return blocks::of_source(o.barometer, &BarometerOptions::offset); },
     .needs = "the key `barometer:`",
     .implied = true},
    {.block = Block::kHardIron,
     .name = "hard_iron",
     .size = 3,
     .unit = "uT",
     .factor = 1,
     .axes = blocks::kBody,
     .member = &Estimate::hard_iron,
     .prior = [](const FilterOptions& o) { return blocks::alike(o.magnetometer ? o.magnetometer->hard_iron : 0); },
     .observed = blocks::with_magnetometer,
     .needs = "the key `magnetometer:`",
     .implied = true},
    {.block = Block::kSoftIronX,
     .name = "soft_iron_x",
     .size = 3,
     .unit = "ppm",
     .factor = 1e6,
     .axes = blocks::kBody,
     .member = &Estimate::soft_iron_x,
     .prior = blocks::soft_iron,
     .observed = blocks::with_magnetometer,
     .needs = "the key `magnetometer:`",
     .implied = true},
    {.block = Block::kSoftIronY,
     .name = "soft_iron_y",
     .size = 3,
     .unit = "ppm",
     .factor = 1e6,
     .axes = blocks::kBody,
     .member = &Estimate::soft_iron_y,
     .prior = blocks::soft_iron,
     .observed = blocks::with_magnetometer,
     .needs = "the key `magnetometer:`",
     .implied = true},
    {.block = Block::kSoftIronZ,
     .name = "soft_iron_z",
     .size = 3,
     .unit = "ppm",
     .factor = 1e6,
     .axes = blocks::kBody,
     .member = &Estimate::soft_iron_z,
     .prior = blocks::soft_iron,
     .observed = blocks::with_magnetometer,
     .needs = "the key `magnetometer:`",
     .implied = true},
    {.block = Block::kMagneticDisturbance,
     .name = "magnetic_disturbance",
     .size = 3,
     .unit = "uT",
     .factor = 1,
     .axes = blocks::kLocal,
     .member = &Estimate::magnetic_disturbance,
     .process =
         [](const FilterOptions& o) { return blocks::of_source(o.magnetometer, &MagnetometerOptions::disturbance); },
     .needs = "the key `magnetometer:`",
     .implied = true},
});

namespace blocks {

/// "gyro_bias_parity_1" and so on.
struct ParityName {
  std::array<char, 32> text{};
  std::size_t size = 0;
  constexpr std::string_view view() const { return {text.data(), size}; }
};
inline constexpr auto kParityNames = [] {
  std::array<ParityName, kParityBlocks> names{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    ParityName& name = names[i];
    const auto add = [&](std::string_view part) {
      for (const char c : part) name.text[name.size++] = c;
    };
    add(kWrittenBlocks[static_cast<std::size_t>(Block::kGyroBias) + i % kImuErrors].name);
    add("_parity_");
    name.text[name.size++] = static_cast<char>('1' + i / kImuErrors);
  }
  return names;
}();

/// The row of parity block `I`: that of its kind, with the prior or the process that follows from the IMUs' own errors.
template <std::size_t I>
constexpr BlockInfo parity_row() {
  constexpr std::size_t kind = I % kImuErrors, parity = I / kImuErrors;
  constexpr bool is_drift = kind / 2 == 1;
  constexpr TriadMember triad = kind % 2 == 0 ? &ImuSensor::gyro : &ImuSensor::accel;
  constexpr ImuErrorKind error = kind / 2 == 0 ? ImuErrorKind::kBias : ImuErrorKind::kScale;
  constexpr BlockInfo like = kWrittenBlocks[static_cast<std::size_t>(Block::kGyroBias) + kind];
  const auto prior = [](const FilterOptions& o) {
    return alike(o.imus.size() > parity + 1 ? parity_sigma(imu_sigmas(o.imus, triad, error)) : 0);
  };
  const auto process = [](const FilterOptions& o) {
    if (o.imus.size() <= parity + 1) return std::optional<BlockProcess>();
    const DriftProcess law = parity_drift(o.imus, triad);
    return law.kind == DriftProcess::Kind::kNone ? std::nullopt : std::optional(BlockProcess{law});
  };
  return {.block = static_cast<Block>(static_cast<std::size_t>(Block::kFirstParity) + I),
          .name = kParityNames[I].view(),
          .size = like.size,
          .unit = like.unit,
          .factor = like.factor,
          .axes = like.axes,
          .member = ParityMember{I},
          .prior = is_drift ? nullptr : +prior,
          .process = is_drift ? +process : nullptr,
          .observed = [](const FilterOptions& o) { return o.imus.size() > parity + 1; },
          .needs = "a list of as many IMUs under `imu:`",
          .implied = true};
}

/// The row of a slow error of a receiver, as position_drift_block() orders them.
template <std::size_t I>
constexpr BlockInfo receiver_row() {
  constexpr bool of_stated = I < kDriftingReceivers;
  constexpr std::size_t receiver = of_stated ? I : I - kDriftingReceivers + 1;
  constexpr std::array<std::string_view, kReceiverDrifts> names{
      "gnss_normalised_drift", "gnss_normalised_drift_1", "gnss_normalised_drift_2", "gnss_normalised_drift_3",
      "gnss_position_drift_1", "gnss_position_drift_2",   "gnss_position_drift_3"};
  return {.block = static_cast<Block>(static_cast<std::size_t>(Block::kFirstReceiverDrift) + I),
          .name = names[I],
          .size = 3,
          .unit = of_stated ? "stated_sigma" : "m",
          .factor = 1,
          .axes = kLocal,
          .member = ReceiverMember{I},
          .process = position_drift<receiver, of_stated>,
          .needs = of_stated ? "a `gnss:` source with a drift that is a share, in that place of the list"
                             : "a `gnss:` source with a drift in metres, in that place of the list",
          .implied = true};
}

/// The row of how a receiver's antenna sways.
template <std::size_t Receiver>
constexpr BlockInfo sway_row() {
  constexpr std::array<std::string_view, kDriftingReceivers> names{"lever_arm_sway", "lever_arm_sway_1",
                                                                   "lever_arm_sway_2", "lever_arm_sway_3"};
  return {.block = static_cast<Block>(static_cast<std::size_t>(Block::kFirstLeverArmSway) + Receiver),
          .name = names[Receiver],
          .size = 3,
          .unit = "m",
          .factor = 1,
          .axes = kBody,
          .member = ReceiverMember{kReceiverDrifts + Receiver},
          .process = lever_arm_sway<Receiver>,
          .needs = "a `gnss:` source with `lever_arm_sway`, in that place of the list",
          .implied = true};
}

}  // namespace blocks

/// All rows.
inline constexpr auto kBlocks = []<std::size_t... I, std::size_t... J, std::size_t... K, std::size_t... L>(
    std::index_sequence<I...>, std::index_sequence<J...>, std::index_sequence<K...>, std::index_sequence<L...>) {
  return std::array<BlockInfo, sizeof...(I) + sizeof...(J) + sizeof...(K) + sizeof...(L)>{
      kWrittenBlocks[I]..., blocks::parity_row<J>()..., blocks::receiver_row<K>()..., blocks::sway_row<L>()...};
}
(std::make_index_sequence<kWrittenBlocks.size()>(), std::make_index_sequence<kParityBlocks>(),
 std::make_index_sequence<kReceiverDrifts>(), std::make_index_sequence<kDriftingReceivers>());

inline constexpr int kBlockCount = static_cast<int>(kBlocks.size());

constexpr int index_of(Block block) { return static_cast<int>(block); }
constexpr const BlockInfo& info(Block block) { return kBlocks[static_cast<std::size_t>(block)]; }

/// Whether the block is position, velocity or attitude, which every run estimates.
constexpr bool is_navigation(Block block) { return index_of(block) <= index_of(Block::kAttitude); }

/// The block of a kind of error, such as kGyroBias, in a parity, from 0.
constexpr Block parity_block(Block kind, int parity) {
  return static_cast<Block>(index_of(Block::kFirstParity) + kImuErrors * parity + index_of(kind) -
                            index_of(Block::kGyroBias));
}

/// The block of the slow error of a receiver, from 0: in units of the sigmas that it states, or in m.
constexpr Block position_drift_block(int receiver, bool of_stated) {
  if (!of_stated && receiver == 0) return Block::kGnssPositionDrift;
  return static_cast<Block>(index_of(Block::kFirstReceiverDrift) +
                            (of_stated ? receiver : kDriftingReceivers + receiver - 1));
}

/// The block of how the antenna of a receiver sways, from 0.
constexpr Block lever_arm_sway_block(int receiver) {
  return static_cast<Block>(index_of(Block::kFirstLeverArmSway) + receiver);
}

/// Whether the block is a rotation. Its error is then a rotation vector, on the left.
constexpr bool is_rotation(Block block) { return std::holds_alternative<Quaterniond Estimate::*>(info(block).member); }

/// First row of a block in the error vector of all blocks.
constexpr int full_offset(Block block) {
  int offset = 0;
  for (int i = 0; i < index_of(block); ++i) offset += kBlocks[static_cast<std::size_t>(i)].size;
  return offset;
}

inline constexpr int kFullSize = full_offset(kBlocks.back().block) + kBlocks.back().size;

/// The blocks that are rotations, without the attitude: the boresight.
inline constexpr int kMountings =
    static_cast<int>(std::count_if(kBlocks.begin(), kBlocks.end(), [](const BlockInfo& row) {
      return is_rotation(row.block) && row.block != Block::kAttitude;
    }));
inline constexpr std::array<Block, kMountings> kMountingBlocks = [] {
  std::array<Block, kMountings> out{};
  std::size_t n = 0;
  for (const BlockInfo& row : kBlocks) {
    if (is_rotation(row.block) && row.block != Block::kAttitude) out[n++] = row.block;
  }
  return out;
}();

namespace blocks {

constexpr bool table_matches_enum() {
  for (int i = 0; i < kBlockCount; ++i) {
    if (index_of(kBlocks[static_cast<std::size_t>(i)].block) != i) return false;
  }
  return true;
}

/// Every block beyond the navigation blocks has either a prior or a process: without one it would silently not be
/// estimated.
constexpr bool every_row_is_whole() {
  return std::all_of(kBlocks.begin(), kBlocks.end(), [](const BlockInfo& row) {
    const bool constant = row.prior != nullptr, process = row.process != nullptr;
    return is_navigation(row.block) ? !constant && !process : constant != process;
  });
}

constexpr bool sizes_match_members() {
  return std::all_of(kBlocks.begin(), kBlocks.end(), [](const BlockInfo& row) {
    if (std::holds_alternative<double Estimate::*>(row.member)) return row.size == 1;
    if (std::holds_alternative<Eigen::Matrix<double, 6, 1> Estimate::*>(row.member)) return row.size == 6;
    if (std::holds_alternative<Eigen::Matrix<double, 9, 1> Estimate::*>(row.member)) return row.size == 9;
    return row.size == 3;
  });
}

}  // namespace blocks
static_assert(blocks::table_matches_enum(), "kBlocks must list the blocks in the order of the enum");
static_assert(blocks::every_row_is_whole(), "a block beyond navigation has either a prior or a process");
static_assert(blocks::sizes_match_members(), "a block has the size of what holds it");
static_assert(full_offset(Block::kAttitude) == 6, "position, velocity and attitude come first");

/// States that one run may have: Eigen keeps no larger matrix off the heap. All blocks at once are more.
inline constexpr int kMostStates = 128;

/// Error of every block, in the order of the table, SI and radians.
using FullError = Eigen::Matrix<double, kFullSize, 1>;
/// Error of the estimated blocks, and its covariance. Their size is known at run time; they need no heap.
using ErrorVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStates, 1>;
using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostStates, kMostStates>;

/// Which blocks a run estimates, and where each stands in its error vector. Position, velocity and attitude come first.
class StateLayout {
 public:
  StateLayout() : StateLayout(std::span<const Block>{}) {}
  /// `extra`: the blocks beyond navigation, in any order. It may name navigation blocks too.
  explicit StateLayout(std::span<const Block> extra);

  int size() const { return size_; }
  bool has(Block block) const { return offset_[static_cast<std::size_t>(block)] >= 0; }
  /// First row of the block, or −1 if it is not estimated.
  int offset(Block block) const { return offset_[static_cast<std::size_t>(block)]; }
  const std::vector<Block>& blocks() const { return blocks_; }

 private:
  std::array<int, kBlocks.size()> offset_;
  std::vector<Block> blocks_;
  int size_ = 0;
};

/// Whether the block has an error that a run can estimate. A constant has none if its 1-sigma is 0, and a process has
/// none if the run does not have it. True for the navigation blocks.
bool has_error(const FilterOptions& options, Block block);

/// The blocks of errors of gyroscopes and accelerometers for which the sensor has an error.
std::vector<Block> imu_error_blocks(const ImuSensor& sensor);

/// The blocks of the slow errors that receivers of the run have.
std::vector<Block> position_drifts(const FilterOptions& options);

/// `wanted`, and after it the blocks that the sources of the run imply, such as their coloured errors, if they are
/// missing.
std::vector<Block> with_implied_blocks(const FilterOptions& options, std::vector<Block> wanted);

}  // namespace piste
