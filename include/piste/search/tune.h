#pragma once
/// The maximum-likelihood noise of a recording.

#include "piste/replay/replay.h"
#include "piste/tune/likeliest_noise.h"

namespace piste {

/// Conditions the recording, estimates its start as replay() does, and then its maximum-likelihood noise
/// (likeliest_noise()). Throws DataError if the recording does not start, or if no innovation is later than 5 s after
/// the start.
Tuning tune(const Recording& recording, const ReplayOptions& options, const TuneOptions& how = {},
            const ProgressCallback& progress = {});

}  // namespace piste
