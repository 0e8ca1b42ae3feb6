#pragma once
/// Low-pass and usable stretches of the signals of two aligned IMUs.

#include <cstddef>
#include <vector>

#include "piste/core/aligned.h"

namespace piste {

/// Indices [first, last) of consecutive samples that are all usable, without a gap.
struct Stretch {
  std::size_t first = 0, last = 0;
  std::size_t size() const { return last - first; }
};

/// The stretches of usable samples, in order.
std::vector<Stretch> usable_stretches(const AlignedImus& imus);

/// Filters the rates and forces of both IMUs by the same zero-phase low-pass of `cutoff` [Hz], stretch by stretch. With
/// 0 they stay as they are. Stretches shorter than two periods of the cut-off are no longer usable.
/// Throws ConfigError if the cut-off is not below half of the rate.
AlignedImus low_passed(const AlignedImus& imus, double cutoff);

}  // namespace piste
