#pragma once
/// Brings recordings into the form that everything else expects: rows in the order of time, gyroscopes and
/// accelerometers side by side.

#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Puts rows in the order of time, and drops those whose time stood in the file before. Both are counted.
void repair_rows(ImuRecording& imu);
void repair_rows(GnssRecording& gnss);
void repair_rows(AttitudeRecording& attitude);
void repair_rows(FixRecording<SpeedFix>& speed);
void repair_rows(FixRecording<HeightFix>& height);
void repair_rows(FixRecording<HeadingFix>& heading);

/// Spreads rows that share a stamp, as of a clock that counts whole seconds, evenly up to the next stamp. Rows of the
/// first stamp, of which the log may have only the last ones, end where the second stamp begins. Rows of the last
/// stamp, and before a gap, have the usual interval.
void spread_stamps(ImuRecording& imu);
void spread_stamps(GnssRecording& gnss);

/// Takes the steps of its clock out of the times of an IMU, whose rows are in the order of the file. Throws DataError
/// if there is no such step in them, or if rows are out of order all the same.
void take_out_steps(ImuRecording& imu, const std::vector<ClockStep>& steps);

/// The steps of a clock that was set while it ran: the time falls back once, by more than the clock is uneven, and goes
/// on evenly. Empty where there is none, or where rows are out of order in another way. A step forward looks as rows
/// that are missing do, and is not among them.
std::vector<ClockStep> clock_steps(const std::vector<double>& time);

/// Multiplies the sigmas of all fixes.
void scale_sigmas(std::vector<GeodeticFix>& fixes, const SigmaScales& by);
void scale_sigmas(std::vector<GnssFix>& fixes, const SigmaScales& by);

/// Lays the rows on the even clock by which a sensor samples, where the logger's stamps scatter about it. The error of
/// rounded or arrival stamps would otherwise act as an error of rotation. The clock is a straight line over the second
/// on either side. Stamps stay as they are if they scatter by less than a hundredth of the interval, or if the rows are
/// increments. So they do if the samples were really taken at their stamps: a late sample then has changed by its delay
/// times the slope between its neighbours. `stamp_jitter` then stays 0.
void even_stamps(ImuRecording& imu);

/// Adds the specific forces of `accel`, which has nothing else, to the rows of `gyro`, which has none. With `instant`,
/// the specific force is interpolated linearly. Otherwise rows are means over intervals, and it is the mean over the
/// gyroscopes' interval.
///
/// The mean is a difference of the velocity that the forces add up to, which is linear over each of their intervals. So
/// no sample is left out or counts twice at any ratio of the rates, and the density of the white noise remains what it
/// was. Linear interpolation between instants also keeps the density at equal rates, where it smooths single values but
/// not their sum. With accelerometers far faster than the gyroscopes it would drop samples.
///
/// Rows of the gyroscopes without forces at their time are left out: at the ends, and in holes of the accelerometers
/// longer than four of their usual intervals. Such holes so remain gaps. These rows, and those of the accelerometers
/// beyond the gyroscopes, are counted in `unpaired`. Throws DataError if the files have no time in common.
ImuRecording paired(const ImuRecording& gyro, const ImuRecording& accel, bool instant);

}  // namespace piste
