#pragma once
/// What two logs of the same run say of one another.
///
/// IMU and GNSS: nothing is believed of the IMU's labels, neither unit nor axes nor clock.
///
/// Clock: on a common grid the turn rate of the track and its accelerations along and across are regressed on the three
/// gyroscopes and the three accelerometers; the multiple correlation is the same in whatever axes and units these are,
/// and is computed at every offset at which the logs have something in common.
///
/// Axes and units: over windows of some seconds the gyroscopes carry the forces to the window's start, where their
/// integral u meets the velocities of the track,
///
///     v(t) − g t = v₀ + scale · R u(t),
///
/// Wahba's problem with a free scale, one lever arm for all windows beside it. It is solved for the units that the
/// turns of the track allow and every signed permutation that the gyroscopes may have against the accelerometers, for
/// det R = +1 and −1, and with gravity in the forces or taken out of them: what is left over tells which of these the
/// log is. det R = −1 with the gyroscopes reversed is an IMU in mirrored axes, with the gyroscopes as they are one that
/// gives minus the specific force. Another reading than the labels' own is accepted only where it leaves far less in
/// nearly all windows, and little; windows in which a sensor clips tell nothing.

#include <optional>
#include <string>
#include <vector>

#include "piste/inspect/gnss_health.h"

namespace piste {

/// Offset of the clocks, found from the motion: gps time = imu time − offset.
struct ClockMatch {
  double offset = 0, sigma = 0;
  double correlation = 0;  ///< multiple, of turn rates or accelerations at that offset, whichever is larger
  double evidence = 0;     ///< log-likelihood over no relation at all, and over the best offset elsewhere
  double over_rival = 0;
};

/// Axes as `axes:` of a configuration has them, such as `-y +x +z`: the rows of a signed permutation.
std::string axes_text(const Matrix3d& axes);

/// How the IMU's labels have to be read for its motion to be that of the track.
struct MotionMatch {
  double gyro_factor = 1;   ///< by which the gyroscopes are to be multiplied: 1, or that of another unit
  double accel_factor = 1;  ///< by which the accelerometers are to be multiplied, as measured: 1.00 where all is well
  Matrix3d gyro_axes = Matrix3d::Identity();  ///< that turn the gyroscopes into what fits the accelerometers' axes
  bool mirrored = false;                      ///< the accelerometers' axes, or their sign, are left-handed
  bool gravity = true;                        ///< gravity stands in the forces
  double residual = 0,
         residual_as_given = 0;  ///< rms of velocity over a window, with that reading and with the labels'
  double change = 0;             ///< rms by which the velocity changes in a window [m/s]: what there is to explain
  std::size_t windows = 0;

  /// `imu: {axes: …}`: the sensor axes that point forward, right, down, such as `-y +x +z`. With mirrored axes they are
  /// left-handed, and no config takes them.
  std::string axes;
  Matrix3d R_bs = Matrix3d::Identity();   ///< the same
  Vector3d lever_arm = Vector3d::Zero();  ///< IMU → antenna in the accelerometers' axes, roughly [m]
  /// What these windows add to the offset of the clocks that was found before [s]; sigma 0: nothing.
  double clock_rest = 0, sigma_clock = 0;
  double tilt = 0;    ///< rotation from those axes to what the motion says, on average [rad]
  double margin = 0;  ///< angle by which the second best axes are further off [rad]

  bool as_given() const { return gyro_factor == 1 && gyro_axes.isIdentity() && !mirrored && gravity; }
};

/// An IMU's log against a receiver's.
struct LogMatch {
  Interval imu, gnss;               ///< spans
  double interval = 0;              ///< median, of the IMU [s]; 0 where times are no seconds, and nothing else is known
  bool increments = false;          ///< that the IMU is said to hold
  double overlap = 0;               ///< seconds in common, as the clocks stand
  std::optional<ClockMatch> clock;  ///< where the motion tells
  std::optional<MotionMatch> motion;
  double turn_ratio = 0;  ///< the turn rate of the gyroscopes over that of the track; 0 where it is not known
  double force = 0;       ///< median magnitude of the specific force [m/s²], as its label has it
};

/// @pre time-ordered recordings, as read_imu and read_gnss give them
LogMatch match(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health);

/// What looks wrong between them.
std::vector<Suspicion> suspicions(const LogMatch& match, const std::string& imu_file, const std::string& gnss_file);

/// Two IMUs or two receivers beside one another.
struct PairMatch {
  double overlap = 0;  ///< seconds in common
  bool same = false;   ///< the same recording twice
  /// Median distance of two antennas, and the scatter of it [m]; NaN for IMUs, and without common time.
  double distance = 0, scatter = 0;
};

PairMatch match(const ImuRecording& one, const ImuRecording& other);
PairMatch match(const GnssRecording& one, const GnssRecording& other);

/// What looks wrong with the second of them.
std::vector<Suspicion> suspicions(const PairMatch& match, const std::string& one, const std::string& other);

}  // namespace piste
