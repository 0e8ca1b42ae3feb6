#pragma once
/// The files of `allan`: the curves as a table, and everything that was found.

#include <string>

#include "piste/recordings/allan.h"

namespace piste {

/// `allan.csv`: a row for each τ; for each axis that was recorded the deviation with its interval (`_lci`, `_uci`), the
/// fitted model's (`_model`) and the Haar wavelet variance of the scale 2τ (`_wv`). SI; empty where a scale is too long
/// to be told.
std::string allan_csv(const AllanFindings& findings);

/// `allan.json`: recordings, processes with their intervals, density and bias instability, models that were tried,
/// warnings, and what the length does not tell. SI.
std::string allan_json(const AllanFindings& findings);

}  // namespace piste
