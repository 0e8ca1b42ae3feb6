#pragma once
/// Fixes that a run finds to be spoilt.

#include "piste/core/log.h"
#include "tune/evidence.h"

namespace piste {

/// The log as a run of it judges it: what the run rejects has sigmas five times as large; of each source one in fifty
/// at most, the worst. Where a run rejects more, its sigmas are too small.
Log with_spoilt_fixes(Log log, const Evidence& run);

/// Whether two copies of a log have the same sigmas.
bool same_sigmas(const Log& a, const Log& b);

}  // namespace piste
