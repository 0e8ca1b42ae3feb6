#pragma once
/// What in a run raises a doubt of its sigmas, before any cause is looked for.

#include <optional>
#include <string>

#include "piste/consistency/verdict.h"
#include "piste/core/options.h"
#include "piste/start/start.h"

namespace piste {

/// Whether a cause is to be looked for. It takes less than it does to say that the sigmas do not hold: the likelihood
/// of a cause decides then.
bool doubtful(const Verdict& verdict, const Log& log, const Solution& filtered);

/// Whether the sigmas are so wrong that it may be the axes.
bool far_off(const Verdict& verdict);

/// Adds a jump to the verdict: the difference of the configured initial heading, if there is one, from that of the
/// whole run, in sigmas as for every constant. The filter may correct a wrong heading within seconds, and the verdict
/// does not look at the first fixes. @pre `filtered` has rows.
void add_heading_jump(const InitialHeading& heading, const Solution& filtered, const Solution* smoothed,
                      Verdict& verdict);

/// The sentence about a magnetometer that shows another field than the Earth's, as one in another unit or one that
/// sticks: the filter explains that by iron beyond its prior, and what else is then likelier only makes up for it.
std::optional<std::string> iron_that_is_none(const Verdict& verdict);

/// The sentence about an IMU of which no bias is estimated, though its sensor file states some: filter and fixes then
/// contradict each other, and a noise that makes up for it is likelier. Nothing where the sigmas hold all the same.
std::optional<std::string> biases_left_out(const Verdict& verdict, const FilterOptions& options);

}  // namespace piste
