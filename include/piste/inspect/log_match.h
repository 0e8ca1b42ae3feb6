#pragma once
/// Compares two logs of the same run.
///
/// For an IMU and a GNSS log this finds the offset of the clocks and the IMU's axes and units from the motion alone.
/// What the labels in the IMU's log say is not used.
///
/// **Clock.** The turn rate of the GNSS track and its accelerations along and across the track are regressed on the
/// three gyroscopes and the three accelerometers. The multiple correlation does not depend on their axes and units. It
/// is computed at every offset at which the logs overlap, and the offset with the largest likelihood is taken. Where a
/// calm motion leaves several, that counts near which the body rests in both logs at a time.
///
/// **Axes and units.** In windows of some seconds the gyroscopes turn the specific forces into the axes at the
/// beginning of the window. Their integral u must fit the velocities of the track,
///
///     v(t) − g t = v₀ + scale · R u(t),
///
/// which is Wahba's problem with a free scale, and with one lever arm for all windows. It is solved for every reading
/// of the labels: every unit that the turns of the track allow, every signed permutation between gyroscopes and
/// accelerometers, det R = +1 and −1, forces with and without gravity. The residuals show which reading is right. det R
/// = −1 with reversed gyroscopes means that the IMU's axes are mirrored; with the gyroscopes as they are, that the IMU
/// gives minus the specific force, or that the track is mirrored. A reading that differs from the labels is accepted
/// only if its residuals are small, and far smaller than those of the labels in nearly all windows. Windows in which a
/// sensor clips are not used.
///
/// **Mirrored tracks.** Where the log has no velocities, and the labels do not fit, all is done once more with latitude
/// and longitude interchanged, which mirrors the track and, but at one latitude, stretches it.

#include <optional>
#include <string>
#include <vector>

#include "piste/inspect/gnss_health.h"

namespace piste {

/// Offset of the clocks, found from the motion: gps time = imu time − offset.
struct ClockMatch {
  double offset = 0, sigma = 0;
  double correlation = 0;  ///< multiple correlation at that offset: the larger of turn rates and accelerations
  double evidence = 0;     ///< log-likelihood of that offset over that of no relation
  double over_rival = 0;   ///< log-likelihood of that offset over that of the best one elsewhere
  bool certain = true;     ///< whether these numbers are enough; if not, a MotionMatch confirmed the offset
  bool by_rest = false;    ///< told by when the body rests alone, good to a second or so: the other numbers are 0
};

/// The rows of a signed permutation as the text of the key `axes`, such as `-y +x +z`.
std::string axes_text(const Matrix3d& axes);

/// The axes and units of the IMU with which its motion is that of the track.
struct MotionMatch {
  double gyro_factor = 1;   ///< by which the gyroscopes must be multiplied: 1, or that of another unit
  double accel_factor = 1;  ///< by which the accelerometers must be multiplied, as measured: near 1 if all is right
  Matrix3d gyro_axes = Matrix3d::Identity();  ///< turn the gyroscopes into the accelerometers' axes
  bool mirrored = false;  ///< whether the accelerometers' axes are left-handed, or their sign is reversed
  bool gravity = true;    ///< whether the forces contain gravity
  double residual = 0,
         residual_as_given =
             0;       ///< rms of velocity in a window, with these axes and units and with those of the labels
  double change = 0;  ///< rms of the velocity's change in a window [m/s], which is to be explained
  std::size_t windows = 0;

  /// The value of the key `axes` of a configuration, such as `-y +x +z`. If the axes are mirrored it is left-handed,
  /// and no configuration accepts it.
  std::string axes;
  Matrix3d R_bs = Matrix3d::Identity();   ///< the same
  Vector3d lever_arm = Vector3d::Zero();  ///< from the IMU to the antenna in the accelerometers' axes, roughly [m]
  /// Correction that these windows give to the offset of the clocks [s]. A sigma of 0 means that there is none.
  double clock_rest = 0, sigma_clock = 0;
  double tilt = 0;                     ///< mean rotation between those axes and the rotations of the windows [rad]
  double margin = 0;                   ///< by how much more the second best axes are rotated [rad]
  std::vector<std::string> as_likely;  ///< other axes that are hardly more rotated: the IMU sits between them

  /// Whether it is the track that is mirrored, as far as one can tell: forces with the other sign look the same, and
  /// then an IMU that is upright by this would hang upside down.
  bool track_mirrored() const { return mirrored && gyro_axes.isIdentity() && R_bs(2, 2) > 0; }
  bool as_given() const { return gyro_factor == 1 && gyro_axes.isIdentity() && !mirrored && gravity; }
};

/// The comparison of an IMU's log with a receiver's.
struct LogMatch {
  Interval imu, gnss;               ///< spans
  double interval = 0;              ///< median, of the IMU [s]; 0 if times are not in seconds: all else is then unknown
  bool increments = false;          ///< whether the IMU's log has increments, by its labels
  double overlap = 0;               ///< seconds in common, by the clocks as they are
  std::optional<ClockMatch> clock;  ///< nothing if the motion does not determine it
  std::optional<MotionMatch> motion;
  bool clock_told = false;  ///< whether a log tells the IMU's clock, and `clock` is what the motion says beyond it
  bool velocities_may_be_late = false;  ///< positions do not tell; an offset below a second may be theirs
  /// Whether this is of the track with latitude and longitude interchanged, as no motion of the IMU is that of the log.
  bool interchanged = false;
  /// Correlation of the IMU's rate about down with the turn rate of the track. Negative: one of the two is mirrored. 0:
  /// unknown.
  double turn_correlation = 0;
  double turn_ratio = 0;  ///< the turn rate of the gyroscopes over that of the track; 0 if unknown
  double force = 0;       ///< median magnitude of the specific force [m/s²], by its label
};

/// Compares an IMU's log with a receiver's. `rest`: when the IMU rests (ImuHealth), which tells the clocks roughly
/// where the motion alone does not; none: that is not looked at.
/// @pre rows are in the order of time, as read_imu and read_gnss give them
LogMatch match(const ImuRecording& imu, const GnssRecording& gnss, const GnssHealth& health,
               const std::vector<Interval>& rest = {});

/// What looks wrong between the two.
std::vector<Suspicion> suspicions(const LogMatch& match, const std::string& imu_file, const std::string& gnss_file);

/// The comparison of two IMUs or of two receivers.
struct PairMatch {
  double overlap = 0;  ///< seconds in common
  bool same = false;   ///< whether they are the same recording
  /// Median distance of two antennas, and its scatter [m]. NaN for IMUs, and without common time.
  double distance = 0, scatter = 0;
  double horizontal = 0;  ///< median horizontal distance, likewise
  double above = 0;       ///< median height of the second antenna over the first, likewise

  /// Why a run should not use the second one, in words; nothing if it may.
  std::string why_left_out(const std::string& first_file) const;
};

PairMatch match(const ImuRecording& one, const ImuRecording& other);
PairMatch match(const GnssRecording& one, const GnssRecording& other);

/// What looks wrong with the second one.
std::vector<Suspicion> suspicions(const PairMatch& match, const std::string& one, const std::string& other);

}  // namespace piste
