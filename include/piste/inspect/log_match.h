#pragma once
/// Compares two logs of the same run.
///
/// From the motion alone, the comparison of an IMU log with a GNSS log estimates the clock offset, the IMU's axes and
/// its units. It does not use the axis and unit labels in the IMU log.
///
/// **Clock.** The turn rate of the GNSS track and its accelerations along and across the track are regressed on the
/// three gyroscopes and the three accelerometers. The multiple correlation does not depend on their axes and units. It
/// is computed at every offset at which the logs overlap, and the maximum-likelihood offset is taken. A calm motion may
/// leave several candidates. Then the candidate near which both logs are stationary at the same times is taken.
///
/// **Axes and units.** In windows of some seconds the gyroscopes rotate the specific forces into the axes at the
/// beginning of the window. The integral u of these forces must fit the velocities of the track,
///
///     v(t) − g t = v₀ + scale · R u(t),
///
/// which is Wahba's problem with a free scale, and with one lever arm for all windows. It is solved for every
/// hypothesis about the labels: every gyroscope unit that the turns of the track allow, every signed permutation
/// between gyroscopes and accelerometers, det R = +1 and −1, forces with and without gravity. The residuals select the
/// hypothesis. det R = −1 with reversed gyroscopes means that the IMU's axes are mirrored. det R = −1 with the
/// gyroscopes as they are means that the IMU gives minus the specific force, or that the track is mirrored. A
/// hypothesis that differs from the labels is accepted only if its residuals are small, and far smaller than the
/// residuals of the labels in nearly all windows. Windows in which a sensor clips are not used.
///
/// **Mirrored tracks.** If the log has no velocities and the labels do not fit, the comparison is repeated with
/// latitude and longitude interchanged. Interchanging mirrors the track and, except at one latitude, stretches it.

#include <optional>
#include <string>
#include <vector>

#include "piste/inspect/gnss_health.h"

namespace piste {

/// Offset of the clocks, estimated from the motion: gps time = imu time − offset. With an offset of 2.5 s, a row
/// stamped 102.5 s was measured at 100 s.
struct ClockMatch {
  double offset = 0, sigma = 0;
  double correlation = 0;  ///< multiple correlation at that offset: the larger one of turn rates and of accelerations
  double evidence = 0;     ///< log-likelihood ratio of that offset to no relation
  double over_rival = 0;   ///< log-likelihood ratio of that offset to the best one elsewhere
  bool certain = true;     ///< whether these numbers are enough; if not, a MotionMatch confirmed the offset
  bool by_rest = false;    ///< estimated from stationary times alone, to about 1 s: the other numbers are 0
};

/// The rows of a signed permutation as the text of the key `axes`, such as `-y +x +z`.
std::string axes_text(const Matrix3d& axes);

/// The axes and units of the IMU with which its motion fits the track.
struct MotionMatch {
  double gyro_factor = 1;   ///< by which the gyroscopes must be multiplied: 1, or the factor of another unit
  double accel_factor = 1;  ///< the same for the accelerometers, as measured: near 1 if the unit is right
  Matrix3d gyro_axes = Matrix3d::Identity();  ///< turn the gyroscopes into the accelerometers' axes
  bool mirrored = false;  ///< whether the accelerometers' axes are left-handed, or their sign is reversed
  bool gravity = true;    ///< whether the forces contain gravity
  double residual = 0,
         residual_as_given =
             0;       ///< rms of the velocity residual in a window, with these axes and units and with the labels
  double change = 0;  ///< rms of the velocity's change in a window [m/s], which the fit has to explain
  std::size_t windows = 0;

  /// The value of the key `axes` of a configuration, such as `-y +x +z`. If the axes are mirrored it is left-handed,
  /// and no configuration accepts it.
  std::string axes;
  Matrix3d R_bs = Matrix3d::Identity();   ///< `axes` as a matrix
  Vector3d lever_arm = Vector3d::Zero();  ///< from the IMU to the antenna in the accelerometers' axes, roughly [m]
  /// Correction to the offset of the clocks, estimated from these windows [s]. A sigma of 0: there is none.
  double clock_rest = 0, sigma_clock = 0;
  double tilt = 0;                     ///< mean angle between R_bs and the rotations of the windows [rad]
  double margin = 0;                   ///< by how much larger this angle is for the second best axes [rad]
  std::vector<std::string> as_likely;  ///< other axes with hardly a larger angle: the IMU sits between them

  bool sign_told = true;  ///< whether the log states the sign of the forces

  /// Whether the track is mirrored, and not the sign of the force reversed. Both look the same. It is the track if a
  /// reversed force would mean an IMU that hangs upside down, and nobody doubts the sign.
  bool track_mirrored() const { return mirrored && sign_told && gyro_axes.isIdentity() && R_bs(2, 2) > 0; }
  bool as_given() const { return gyro_factor == 1 && gyro_axes.isIdentity() && !mirrored && gravity; }
};

/// The comparison of an IMU's log with a receiver's.
struct LogMatch {
  Interval imu, gnss;       ///< spans
  double interval = 0;      ///< median interval of the IMU [s]; 0 if times are not in seconds: all else is then unknown
  bool increments = false;  ///< whether the IMU's log has increments, by its labels
  double overlap = 0;       ///< seconds in common, by the clocks as logged
  std::optional<ClockMatch> clock;  ///< nothing if the motion does not determine it
  std::optional<MotionMatch> motion;
  bool clock_told = false;              ///< whether a log states the IMU's clock; `clock` is then the residual offset
  bool velocities_may_be_late = false;  ///< their delay is not known; an offset below 1 s may be this delay
  /// Whether this result is of the track with latitude and longitude interchanged, as no motion of the IMU fits the log
  /// as given.
  bool interchanged = false;
  /// Correlation of the IMU's rate about down with the turn rate of the track. Negative: one of the two is mirrored. 0:
  /// unknown.
  double turn_correlation = 0;
  double turn_ratio = 0;  ///< the turn rate of the gyroscopes over that of the track; 0 if unknown
  double force = 0;       ///< median magnitude of the specific force [m/s²], by its label
};

/// Compares an IMU's log with a receiver's. `rest`: times in which the IMU is stationary (ImuHealth::rest). They
/// determine the clock offset to about 1 s where the motion alone does not. Empty: stationary times are not compared.
/// @pre rows are in the order of time, as read_imu and read_gnss give them
LogMatch match(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health,
               const std::vector<Interval>& rest = {});

/// Lists the faults of the two logs relative to each other.
std::vector<Suspicion> suspicions(const LogMatch& match, const std::string& imu_file, const std::string& gnss_file);

/// The comparison of two IMUs or of two receivers.
struct PairMatch {
  double overlap = 0;  ///< seconds in common
  bool same = false;   ///< whether they are the same recording
  /// Median distance of two antennas, and its scatter [m]. NaN for IMUs, and without common time.
  double distance = 0, scatter = 0;
  double horizontal = 0;  ///< median horizontal distance [m]; NaN likewise
  double above = 0;       ///< median height of the second antenna above the first [m]; NaN likewise

  /// Why a run should not use the second one, in words; nothing if it may.
  std::string why_left_out(const std::string& first_file) const;
};

PairMatch match(const ImuRecording& one, const ImuRecording& other);
PairMatch match(const GnssRecording& one, const GnssRecording& other);

/// Lists the faults of the second log relative to the first.
std::vector<Suspicion> suspicions(const PairMatch& match, const std::string& one, const std::string& other);

}  // namespace piste
