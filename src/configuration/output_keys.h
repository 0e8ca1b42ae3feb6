#pragma once
/// Reads the keys `output`, `week` and `events` of a replay, but for the rates.

#include <vector>

#include "piste/configuration/replay_config.h"

namespace piste {

/// Throws ConfigError, also if what is asked for needs covariances that `smoother` does not give.
OutputOptions read_output_options(const Config& config, SmootherKind smoother);

/// Throws ConfigError if `at` is no point of `output`.
std::vector<EventSource> read_events(const Config& config, const OutputOptions& output, SmootherKind smoother);

}  // namespace piste
