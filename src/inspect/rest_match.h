#pragma once
/// Estimates the offset of two clocks from the times in which each of two logs shows a stationary body.

#include <optional>
#include <vector>

#include "piste/core/log.h"

namespace piste {

/// Stationary times by one log: intervals in ascending order, within the log's `span`.
struct Rests {
  std::vector<Interval> intervals;
  Interval span;
};

/// Time of `one` minus time of `other` at which the stationary times agree best. It maximizes the mutual information of
/// the two logs, over their seconds, minus their variation of information (Meila 2007, Journal of Multivariate Analysis
/// 98). The accuracy is about 1 s. Nothing if stationary times determine no offset, or several that are seconds apart.
std::optional<double> match_rests(const Rests& one, const Rests& other);

}  // namespace piste
