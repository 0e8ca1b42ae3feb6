#pragma once
/// Conditioning: turns the recordings of the sensors into the input of the filter, with one clock, body axes,
/// increments and the world frame.

#include "piste/core/log.h"
#include "piste/core/options.h"

namespace piste {

/// Turns a recording into a Log.
///
/// **IMU.** Rows are turned into body axes and their times into GPS time. Each row becomes the increments over the
/// interval since the row before. These are the row itself if it has increments, or its value times the interval if it
/// is a mean. For instantaneous samples they are the integral of a cubic spline. The first row covers one period; with
/// instantaneous samples it only begins the first interval.
///
/// Numbers below are the defaults of `options.behaviour`.
///
/// **Gaps.** A gap is an interval above 1.5 periods after which the rows stay late by half a period or more. This must
/// hold however many of the eight intervals on either side are added: late, rounded and bunched time stamps are no
/// gaps. The period is the mean interval where no row is missing. A gap is filled by samples marked `gap`, one about
/// every period. They lie on the straight line between the mean rates of the 0.2 s on either side. Their noise is twice
/// the error of such lines within 10 s of the gap, or within five times its length if that is more. The row after the
/// gap covers one period. An interval above 300 s is an error.
///
/// **Clipping.** A sample with a component at 0.999 of the range or more is marked as clipped. Beyond twice the range,
/// the component is replaced by the mean of its neighbours.
///
/// **Spikes.** One or two rows that depart from their neighbours by more than a body can move are interpolated
/// linearly, marked `interpolated`, and counted (condition/spikes.h defines a spike). The noise of such a sample is the
/// rms error of the same interpolation at the rows around it.
///
/// **Several IMUs.** If the options name several IMUs, each is conditioned as above by itself. The samples are then
/// their weighted mean at the place, in the axes and at the epochs of the first. Missing and faulty samples of single
/// IMUs are excluded. `parity` has their differences, and `counts.imus` the exclusions (docs/several_imus.md).
///
/// **GNSS and attitude.** Fixes outside the time of the IMU are left out and counted, and so are GNSS fixes in an
/// outage. The others are turned into w, whose origin is the first of them. Times of all sources are brought to the
/// same GPS week.
///
/// **Standstill.** Stretches of rest are those of detect_rest(), if the options ask for them.
///
/// Throws DataError if a needed source is missing, or if the sources have no time in common.
Log condition(const Recording& recording, const ConditioningOptions& options);
/// The same for a recording that is not needed afterwards: the rows of its IMU are consumed.
Log condition(Recording&& recording, const ConditioningOptions& options);

/// The same in a known world frame, such as that of the preceding stretch. Then no fix is needed.
Log condition(const Recording& recording, const ConditioningOptions& options, const World& world);

/// The same for the IMU alone: its samples, magnetic field and counts. Throws as above.
Log condition_imu(ImuRecording recording, const ConditioningOptions& options);

}  // namespace piste
