#pragma once
/// When the body stands still, learned from the log itself.
///
/// A window of a second is at rest where GNSS says so (mean velocity within its noise, or position that does not move)
/// and rate and force are as quiet as at rest. How quiet that is, a running engine and a breathing skier decide: the
/// signature of rest is learned where GNSS is there, as is that of motion, and in an outage both must agree that the
/// body stands. Where the two signatures overlap, no rest is claimed in an outage: one false rest costs more than many
/// missed ones.

#include "piste/core/aligned.h"
#include "piste/core/options.h"

namespace piste {

/// Rest intervals of at least a second, their ends drawn in by a quarter of one.
std::vector<Interval> detect_rest(const Log& log);

/// The same, without GNSS, of two IMUs: from the reference, whose rates have no bias worth the name. A window is at
/// rest where its mean rate is no more than sway, and its rates and forces are quiet. Signals low-passed before, as a
/// tactical IMU's forces are quantised.
std::vector<Interval> detect_rest(const AlignedImus& imus);

/// The log with these rest intervals, in order, and with `at_rest` of the samples that lie whole within one of them.
Log with_rest(Log log, std::vector<Interval> rest);

}  // namespace piste
