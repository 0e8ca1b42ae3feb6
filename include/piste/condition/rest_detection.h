#pragma once
/// Detects when the body is stationary.
///
/// A window of one second is at rest if two conditions hold. GNSS shows rest: its mean velocity is within its noise, or
/// its position does not move. And rate and force are as quiet as at rest. That level differs between a running engine
/// and a breathing skier. It is therefore learned from the log: from the windows in which GNSS shows rest, and from the
/// windows in which it shows motion.
///
/// In an outage, rate and force alone decide: they must be as quiet as at rest, and quieter than in motion. If these
/// levels cannot be separated, no rest is reported in an outage: one false rest costs more than many missed ones.

#include "piste/core/aligned.h"
#include "piste/core/options.h"

namespace piste {

/// Rests of at least `shortest`, one second. Each interval is shortened by `drawn_in`, a quarter of a second, at both
/// ends.
std::vector<Interval> detect_rest(const Log& log, const RestOptions& options = {});

/// The same for two aligned IMUs, without GNSS. It uses the reference, whose bias is negligible: a window is at rest if
/// its mean rate is no more than sway and its rates and forces are quiet. @pre Signals are low-passed, because the
/// forces of a tactical IMU are quantised.
std::vector<Interval> detect_rest(const AlignedImus& imus, const RestOptions& options = {});

/// The log with the rests `rest`, and with `at_rest` set in the samples that lie entirely within one of them. @pre
/// `rest` is in order.
Log with_rest(Log log, std::vector<Interval> rest);

}  // namespace piste
