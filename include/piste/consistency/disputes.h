#pragma once
/// Stretches over which a source was not believed.

#include <string>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// One stretch: its fixes, one after the other, were left out.
struct Dispute {
  int source = 0;  ///< index into Solution::sources
  Interval during;
  std::size_t fixes = 0;
  double size = 0;        ///< of the first residual outside the gate, SI
  bool repeated = false;  ///< the source repeated itself
  bool believed = false;  ///< it ended as the filter gave in, and not as the source came back
};

/// Disputes that lasted `shortest` seconds or longer, in the order of their ends.
std::vector<Dispute> disputes_of(const Solution& solution, double shortest = 3);

/// One line for a reader: which source, from when, how long, by how much, and how it ended.
std::string text_of(const Dispute& dispute, const Solution& solution);

}  // namespace piste
