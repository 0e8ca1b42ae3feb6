#pragma once
/// Reads the keys for gaps, spikes, standstill, initialisation and fault detection.

#include "piste/core/behaviour.h"
#include "piste/io/config.h"

namespace piste {

/// Reads `gate`, `rest`, `trust`, `gaps` and `spikes`; a key that is missing has its default. Throws ConfigError with
/// the line and the range if a value is out of it.
BehaviourOptions read_behaviour(const Config& config);

/// Reads the keys of the map `initial` for the search of an unknown heading: hypotheses, listened and look_back. If the
/// heading is known (`searched` is false), they are an error. Throws ConfigError.
void read_heading_search(const Config& initial, bool searched, StartOptions& start);

}  // namespace piste
