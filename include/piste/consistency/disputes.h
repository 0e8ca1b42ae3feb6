#pragma once
/// Lists the disputes of a run: series of fixes that the filter excluded because their receiver jumped or repeated
/// itself.

#include <string>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// One series of excluded fixes.
struct Dispute {
  int source = 0;  ///< index into Solution::sources
  Interval during;
  std::size_t fixes = 0;
  double size = 0;        ///< of the first residual outside the gate, SI
  bool repeated = false;  ///< whether the receiver repeated a fix (otherwise it jumped)
  bool believed =
      false;  ///< whether it ended because the filter used the source again, and not because the source came back
};

/// Disputes that lasted `shortest` seconds or longer, in the order of their ends.
std::vector<Dispute> disputes_of(const Solution& solution, double shortest = 3);

/// A dispute as one line of text: which source, from when, how long, by how much, and how it ended.
std::string text_of(const Dispute& dispute, const Solution& solution);

}  // namespace piste
