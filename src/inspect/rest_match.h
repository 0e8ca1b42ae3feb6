#pragma once
/// Finds how far two clocks are apart from when a body rests by each of two logs.

#include <optional>
#include <vector>

#include "piste/core/log.h"

namespace piste {

/// When a body rests by one log: intervals in ascending order, within the log's `span`.
struct Rests {
  std::vector<Interval> intervals;
  Interval span;
};

/// Time of `one` minus that of `other` for which rest in one is rest in the other: for which the two tell most of each
/// other (the mutual information over the seconds of both) beyond what they leave open (the variation of information;
/// Meila 2007, Journal of Multivariate Analysis 98). Good to a second or so. Nothing if rest tells none, or several
/// that are seconds apart.
std::optional<double> match_rests(const Rests& one, const Rests& other);

}  // namespace piste
