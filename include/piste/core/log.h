#pragma once
/// The measurements of a run, in two forms: as in the files (Recording), and as the filter takes them (Log).

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "piste/math/earth.h"

namespace piste {

// ---- As the files have it: sensor clock, sensor axes, SI and radians. ----

/// Counts of the rows that the key `repair` changed in a file.
struct RepairedRows {
  std::size_t sorted = 0;      ///< rows that stood behind a later one, and were put in their place
  std::size_t dropped = 0;     ///< rows whose time stood in the file before
  std::size_t unreadable = 0;  ///< rows that were left out, as they could not be read

  RepairedRows& operator+=(const RepairedRows& other) {
    sorted += other.sorted;
    dropped += other.dropped;
    unreadable += other.unreadable;
    return *this;
  }
};

/// A clock that was set while it ran: what it jumped, and the time of the last row before it, as logged.
struct ClockStep {
  double time = 0, step = 0;  ///< [s]; a clock that was set back by 0.7 s has a step of -0.7 s
  bool operator==(const ClockStep&) const = default;
};

/// One IMU file. Rows are rates and specific forces, or increments since the row before.
struct ImuRecording {
  std::string file;
  bool increments = false;
  std::vector<double> time;
  std::vector<Vector3d> gyro, accel;
  std::vector<Vector3d> magnetic;   ///< [µT]; empty, or one for each row
  std::vector<double> temperature;  ///< [°C]; empty, or one for each row
  RepairedRows repaired = {};       ///< of both files, where gyroscopes and accelerometers stand apart
  double stamp_jitter = 0;          ///< rms by which stamps were moved to the even clock of the samples [s]
  /// Rows left out, as the other of the two files has none at their time, or as one triad is empty or all are zero.
  std::size_t unpaired = 0;
};

/// Which kind of solution a fix is. kPrecise is a carrier-phase solution that is neither float nor fixed, such as PPP.
enum class FixQuality : std::uint8_t {
  kUnknown,
  kSingle,
  kSbas,
  kDifferential,
  kPrecise,
  kFloat,
  kFixed,
  kDeadReckoned
};
inline constexpr std::size_t kQualities = 8;

/// Velocity of a fix. If only the horizontal velocity was measured, the down sigma is infinite and the value along down
/// is 0.
struct FixVelocity {
  Vector3d value, sigma;
  bool has_down() const { return std::isfinite(sigma.z()); }
};

/// Correlations of the errors of a position: of north and east, north and down, east and down.
using Correlation = Vector3d;

/// The correlations of a covariance [m²] along north, east, down. Rounding in a log may leave an indefinite matrix: all
/// correlations are then scaled down until it is positive definite. Zero where a variance is not above zero.
///
///     correlations(0.04 * Matrix3d::Identity())  // → {0, 0, 0}
Correlation correlations(const Matrix3d& covariance);

/// One GNSS fix: position and velocity of the receiver's antenna. Velocity and sigmas are along local north-east-down.
struct GeodeticFix {
  double time = 0;
  Geodetic position;
  Vector3d sigma_position;
  std::optional<FixVelocity> velocity;
  FixQuality quality = FixQuality::kUnknown;
  Correlation correlation = Correlation::Zero();
  Vector3d slow_level = Vector3d::Zero();   ///< as GnssFix has it; 0: not yet known
  Vector3d slow_change = Vector3d::Zero();  ///< as GnssFix has it
  std::uint8_t satellites = 0;              ///< that were used for it; 0: the log does not say
};

/// The size σ̄ of a slow error of a receiver whose sigmas change. That of a first-order Gauss-Markov process follows its
/// white noise with a delay: d/dt σ̄² = (σ² − σ̄²) 2/τ, here with τ of two minutes. A state in units of σ itself would
/// leap where a stated accuracy is rounded differently. A stated sigma that differs from σ̄ by more than a factor of e
/// is of another kind of fix, such as one whose ambiguities are fixed: σ̄ is then that at once.
///
/// Whether the error follows its size is not known: a filter would otherwise take each change of σ̄ for information on
/// the error. So the state may change by as much. The variance of that, relative to the one of the state, is
///
///     (Δ ln σ̄)² + d² Δt/T,   d = ln σ̄ − m,   d/dt m = d/T,   T = τ/2,
///
/// the square of each leap, and of a lasting trend over each T. After a leap of a factor of e nothing is left.
class SlowLevel {
 public:
  /// σ̄/σ of the next fix, in the order of time; 1 for the first one.
  Vector3d next(double time, const Vector3d& sigma);
  /// The variance by which a state in units of σ̄ may have changed since it was asked for last, relative to that of the
  /// state. It is told in pieces of a thousandth, so that constant sigmas cost nothing.
  Vector3d take_change();

 private:
  bool begun_ = false;
  double time_ = 0;
  Vector3d level_ = Vector3d::Zero();  ///< ln σ̄
  Vector3d trend_ = Vector3d::Zero();  ///< m
  Vector3d change_ = Vector3d::Zero();
};

/// Factors of the sigmas that a receiver states.
struct SigmaScales {
  double position = 1;  ///< of positions
  double height = 1;    ///< of their heights, besides `position`
  double velocity = 1;  ///< of velocities
  /// Of positions of each FixQuality, besides `position`; 0: no own factor, which is 1.
  std::array<double, kQualities> of_quality{};
  double of(FixQuality quality) const {
    const double own = of_quality[static_cast<std::size_t>(quality)];
    return own > 0 ? own : 1;
  }
};

/// One GNSS file.
struct GnssRecording {
  std::string file;
  std::vector<GeodeticFix> fixes;
  std::size_t without_fix = 0;  ///< epochs of the file without a fix: it says so, or has latitude and longitude 0
  std::size_t not_used = 0;     ///< fixes of a quality that is not used, such as dead-reckoned ones
  std::size_t above_sea = 0;    ///< fixes whose height is above the sea, as the log has no height of the geoid
  std::size_t unchecked = 0;    ///< sentences without a right checksum, of a log in which none has one
  double velocity_latency = 0;  ///< how late its velocities come, as the log itself says [s]
  RepairedRows repaired = {};
};

/// Attitude of a reference IMU's axes in local north-east-down: (roll, pitch, heading).
struct EulerFix {
  double time = 0;
  Vector3d angles, sigma;
};

/// One attitude file.
struct AttitudeRecording {
  std::string file;
  std::vector<EulerFix> fixes;
  std::size_t not_valid = 0;  ///< epochs of the file whose attitude the reference itself marks as not valid
  RepairedRows repaired = {};
};

/// Speed by a wheel.
struct SpeedFix {
  double time = 0, speed = 0, sigma = 0;
};

/// Height over the ellipsoid from a barometer, with an unknown offset.
struct HeightFix {
  double time = 0, height = 0, sigma = 0;
};

/// Azimuth of a baseline on the body in the local level, and its pitch above the level, if it was measured [rad].
struct HeadingFix {
  double time = 0, heading = 0, sigma = 0;
  std::optional<double> pitch = std::nullopt;
  double sigma_pitch = 0;
};

/// A file of a sensor whose fixes are one number with its sigma: SpeedFix, HeightFix or HeadingFix.
template <class Fix>
struct FixRecording {
  std::string file;
  std::vector<Fix> fixes;
  RepairedRows repaired = {};
};

/// All files of a run.
struct Recording {
  ImuRecording imu;
  std::vector<GnssRecording> gnss;
  std::vector<AttitudeRecording> attitude;
  FixRecording<SpeedFix> speed = {};
  FixRecording<HeightFix> height = {};
  FixRecording<HeadingFix> heading = {};
  std::vector<ImuRecording> further = {};  ///< of several IMUs on one body: all but `imu`
};

// ---- As the filter takes it: GPS time, body axes, world frame. ----

/// Densities of the white noise that is added in a gap, for the motion that the straight line through the gap may miss.
/// Each sample has a place for it, and seven digits are enough.
struct GapNoise {
  float gyro = 0;   ///< rad/s/sqrt(Hz)
  float accel = 0;  ///< m/s²/sqrt(Hz)
};

/// A GapNoise or none, in the size of a GapNoise: a log has millions of samples.
class MaybeNoise {
 public:
  MaybeNoise() = default;
  MaybeNoise(const GapNoise& noise) : noise_(noise) {}
  MaybeNoise(const std::optional<GapNoise>& noise) : noise_(noise.value_or(kNone)) {}
  bool has_value() const { return noise_.gyro >= 0; }
  explicit operator bool() const { return has_value(); }
  /// @pre has_value()
  const GapNoise& operator*() const { return noise_; }
  const GapNoise* operator->() const { return &noise_; }
  void reset() { noise_ = kNone; }

 private:
  static constexpr GapNoise kNone{-1, -1};
  GapNoise noise_ = kNone;
};

/// One IMU sample: rotation and velocity increments over (time − interval, time], in body axes.
struct ImuSample {
  double time = 0, interval = 0;
  Vector3d dtheta = Vector3d::Zero(), dvel = Vector3d::Zero();
  std::uint8_t clipped_gyro = 0, clipped_accel = 0;  ///< bit i is set where axis i stands at the sensor's range
  MaybeNoise gap = {};                               ///< set where the sample fills a gap: it was not measured
  MaybeNoise interpolated = {};                      ///< set where a spike was interpolated: the noise that this adds
  bool at_rest = false;                              ///< set where the rest detector finds the body stationary
};

/// One GNSS fix: position and velocity of the receiver's antenna, in w, with sigmas along the local level there: north,
/// east, down. A velocity without down is that of its north and east.
struct GnssFix {
  double time = 0;
  Vector3d position, sigma_position;
  std::optional<FixVelocity> velocity;
  Correlation correlation = Correlation::Zero();
  /// Size of its slow error (PositionDrift) relative to its sigmas: the sigmas stated over the last minute, divided by
  /// those of this fix (SlowLevel).
  Vector3d slow_level = Vector3d::Ones();
  Vector3d slow_change = Vector3d::Zero();  ///< variance by which that error may have changed (SlowLevel)
  bool runs_away = false;                   ///< its position is that of a ramp fault, and is not used
  FixQuality quality = FixQuality::kUnknown;
  std::uint8_t satellites = 0;  ///< as GeodeticFix has it

  /// L with L Lᵀ = the covariance of the position along the local level [m]: lower triangular, the sigmas on the
  /// diagonal where axes are not correlated.
  Matrix3d position_factor() const;
};

/// Attitude of the reference axes, R_wr, and the covariance [rad²] of its rotation-vector error in w.
struct AttitudeFix {
  double time = 0;
  Quaterniond q_wr;
  Matrix3d covariance;
};

/// A parity of the rates or of the specific forces of several IMUs (core/imu_array.h): its mean over the fix, and the
/// measured 1-sigma of its white noise; 0: not measured.
struct Parity {
  Vector3d value = Vector3d::Zero(), sigma = Vector3d::Zero();
};

/// The parities of several IMUs, in b, moved to the place of the first, over `duration`. Its time is the start of the
/// last sample: its drifts are those of that time. What some IMU did not measure is missing.
struct ParityFix {
  double time = 0, duration = 0;
  std::optional<Parity> gyro = {}, accel = {};
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();  ///< of the mean IMU, as measured
};

/// Magnetic field in body axes, and that of the Earth at the place, along the local level: north, east, down [µT].
struct MagneticSample {
  double time = 0;
  Vector3d field;
  Vector3d earth = Vector3d::Zero();
};

struct Interval {
  double start = 0, end = 0;
  bool contains(double t) const { return t >= start && t <= end; }
};

/// Why an IMU was excluded from the mean of several.
enum class ImuFault : std::uint8_t { kClipped, kStuck, kSpike, kSilent, kBiased };

/// A stretch in which one of several IMUs was excluded.
struct ImuAbsence {
  ImuFault fault = ImuFault::kClipped;
  bool gyro = false, accel = false;  ///< which of its triads
  Interval time;
};

/// One of several IMUs in a run.
struct ImuReport {
  std::string name;
  Vector3d place = Vector3d::Zero();      ///< p_bu_b: from the first IMU to it, as used
  std::size_t left_out = 0;               ///< epochs without it on one axis or more
  std::vector<ImuAbsence> absences = {};  ///< in the order of their starts
};

/// The first fixes of a receiver that the later ones contradict: how many, and their error [m]. Their sigmas were
/// increased by it.
struct FirstFixes {
  std::size_t count = 0;
  double off = 0;
};

/// A ramp fault: positions of a receiver that run away from its velocities. They are not used.
struct RampFault {
  Interval span;
  std::size_t count = 0;
  double off = 0;  ///< largest distance from the track by the velocities [m]
};

/// Counts of what conditioning left out or changed. Nothing is left out without a count.
struct LogCounts {
  std::size_t imu_gaps = 0, imu_rejected = 0, imu_clipped = 0, imu_spikes = 0;
  std::vector<std::size_t> gnss_withheld, gnss_outside;  ///< per receiver: in an outage; outside the IMU's span
  std::vector<std::size_t> attitude_outside;
  std::vector<std::size_t> gnss_without_fix, attitude_not_valid;  ///< per source, over the whole file
  std::vector<std::size_t> gnss_not_used = {};                    ///< per receiver: of a quality that is not used
  std::size_t imu_unpaired = 0;                                   ///< over the whole file, and so are these:
  double stamp_jitter = 0;                                        ///< of the IMU, rms [s]
  RepairedRows imu_repaired = {};
  std::vector<RepairedRows> gnss_repaired = {}, attitude_repaired = {};  ///< per source
  std::vector<FirstFixes> gnss_contradicted = {};                        ///< per receiver
  std::vector<std::vector<RampFault>> gnss_ramps = {};                   ///< per receiver
  std::vector<ImuReport> imus = {};                                      ///< of several IMUs
  /// Fixes of odometer, barometer and dual antenna outside the IMU's span.
  std::size_t speed_outside = 0, height_outside = 0, heading_outside = 0;
  RepairedRows speed_repaired = {}, height_repaired = {}, heading_repaired = {};  ///< over their whole files
};

/// All measurements of a run as the filter takes them: in the order of time, on one clock. `gnss[i]` and `attitude[i]`
/// are the fixes of source i.
struct Log {
  World world;
  std::vector<ImuSample> imu;
  std::vector<std::vector<GnssFix>> gnss;
  std::vector<std::vector<AttitudeFix>> attitude;
  std::vector<MagneticSample> magnetic;
  std::vector<SpeedFix> speed;
  std::vector<HeightFix> height;
  std::vector<HeadingFix> heading;
  std::vector<std::vector<ParityFix>> parity = {};  ///< of several IMUs, one fewer than there are
  std::vector<Interval> rest;
  LogCounts counts;
};

/// The log with `part(series)` in place of each series of samples and fixes, source by source. A member that is new to
/// Log does not compile here until it is treated as well.
template <class Part>
Log with_each_series(const Log& log, Part&& part) {
  const auto of_each = [&part](const auto& sources) {
    std::decay_t<decltype(sources)> parts;
    for (const auto& series : sources) parts.push_back(part(series));
    return parts;
  };
  const auto& [world, imu, gnss, attitude, magnetic, speed, height, heading, parity, rest, counts] = log;
  return {.world = world,
          .imu = part(imu),
          .gnss = of_each(gnss),
          .attitude = of_each(attitude),
          .magnetic = part(magnetic),
          .speed = part(speed),
          .height = part(height),
          .heading = part(heading),
          .parity = of_each(parity),
          .rest = rest,
          .counts = counts};
}

}  // namespace piste
