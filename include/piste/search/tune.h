#pragma once
/// The likeliest noise of a recording.

#include "piste/replay/replay.h"
#include "piste/tune/likeliest_noise.h"

namespace piste {

/// Conditions the recording, finds its start as replay() does, and the likeliest noise with it (likeliest_noise()).
/// Throws DataError if the recording does not start, or no innovation is later than 5 s after the start.
Tuning tune(const Recording& recording, const ReplayOptions& options, const TuneOptions& how = {},
            const ProgressCallback& progress = {});

}  // namespace piste
