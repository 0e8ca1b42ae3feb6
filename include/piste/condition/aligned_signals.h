#pragma once
/// What is done to both IMUs' signals alike, once they are brought together.

#include <cstddef>
#include <vector>

#include "piste/core/aligned.h"

namespace piste {

/// Indices [first, last) of samples that follow one another without a gap and are all usable.
struct Stretch {
  std::size_t first = 0, last = 0;
  std::size_t size() const { return last - first; }
};

/// The stretches of usable samples, in order.
std::vector<Stretch> usable_stretches(const AlignedImus& imus);

/// Both IMUs' rates and forces through the same zero-phase low-pass of `cutoff` [Hz], stretch by stretch; 0 = as they
/// are. Stretches shorter than two periods of the cut-off are no longer usable.
/// Throws ConfigError where the cut-off is not below half of the rate.
AlignedImus low_passed(const AlignedImus& imus, double cutoff);

}  // namespace piste
