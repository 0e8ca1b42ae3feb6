#pragma once
// Four numbers that a wide processor takes at a time, for functions that are PISTE_WIDE. They go by reference: as
// values they would have another interface where a processor is not wide.

#include <cstring>

#include "math/wide.h"

namespace piste {

using Four = double __attribute__((vector_size(4 * sizeof(double))));

/// The four numbers at p, which need not be aligned.
PISTE_INSIDE void load(const double* p, Four& four) { std::memcpy(&four, p, sizeof four); }
PISTE_INSIDE void store(const Four& four, double* p) { std::memcpy(p, &four, sizeof four); }

}  // namespace piste
