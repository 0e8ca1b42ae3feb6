#pragma once
/// Warnings about a filtered run that a user must know before relying on it.

#include <string>
#include <string_view>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// One sentence for each of the first five disputes of a GNSS receiver's positions or velocities (disputes.h), and one
/// for all later ones. verdict.h states whether the sigmas hold.
std::vector<std::string> warnings_of(const Solution& filtered);

/// One line for each of several IMUs that was excluded at times: how often, why, and when first.
std::vector<std::string> absence_lines(const std::vector<ImuReport>& imus);

/// A fault of an IMU in a word, such as "stuck".
std::string_view name_of(ImuFault fault);

/// The noise that an adaptive filter estimated, in one line. @pre it adapted
std::string adapted_line(const AdaptedNoise& adapted);

/// Statistics of a batch, in one line.
std::string batch_line(const BatchSummary& batch);

}  // namespace piste
