#pragma once
/// The total error that a receiver states for its positions is never lowered by innovations. A slow error (atmosphere,
/// multipath, float ambiguities) moves fixes and track together, so that innovations show the white part alone. What
/// they leave of the stated sigma is therefore taken for a slow error.

#include <vector>

#include "tune/noise_search.h"

namespace piste {

/// `noise` with a slow error that makes up, with the white one, `stated` times the sigmas of the log at least, axis by
/// axis. A white part that may be as large by its 95 % interval, `reach` times what was found, is as large. The same
/// noise where the user says that it is white. A sigma beyond that of any receiver is a placeholder, and states
/// nothing: the total is then that of a single point.
ReceiverNoise with_stated_total(ReceiverNoise noise, const Vector3d& stated, double reach = 1);

/// The same of every receiver of a model. `intervals` are those of `knobs`. The correlation time of what is added is
/// where the likelihood of `log` and its prior are highest.
NoiseModel with_stated_totals(NoiseModel model, const std::vector<Vector3d>& stated,
                              const std::vector<NoiseKnob>& knobs, const std::vector<LogInterval>& intervals,
                              const NoiseSearch& search, const JudgedLog& log);

}  // namespace piste
