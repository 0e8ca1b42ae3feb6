#pragma once
/// From what the sensors wrote to what the filter takes: one clock, body axes, increments, world frame.

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Turns a recording into a Log.
///
/// IMU: rows are turned into b, their times into GPS time, and each becomes the increments over the interval since
/// the row before: a mean over that interval times its length, or the integral of a cubic spline through
/// instantaneous samples, or increments as they are. The first row begins one median interval earlier; an
/// instantaneous one only begins the first interval. A gap is an interval above 1.5 times the median that its
/// neighbours do not make up for (late time stamps are not gaps). It is filled by samples marked `gap` at about the
/// median interval, on the straight line between the mean rates of the 0.2 s on either side, with twice the noise
/// that such a line has within 10 s (or five times the gap); the row after it covers one median interval. An
/// interval above 300 s is refused. A sample with a component at 0.999 of its range is marked as clipped; beyond
/// twice the range, its neighbours' mean is taken.
///
/// GNSS and attitude: fixes before or after the IMU are counted as outside, those of GNSS in an outage as withheld; the
/// others are turned into w, whose origin is the first of them. Weeks of the sources are made one.
///
/// Rests are those of detect_rest(), where the options ask for them.
/// Throws DataError where a needed source is missing, or nothing has a time in common.
Log condition(const Recording& recording, const ConditioningOptions& options);

/// The IMU's part alone: its samples, magnetic field and counts. Throws DataError as above.
Log condition_imu(const ImuRecording& recording, const ConditioningOptions& options);

}  // namespace piste
