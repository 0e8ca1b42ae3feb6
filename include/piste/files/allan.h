#pragma once
/// The files of `allan`: the curves as a table, and all results.

#include <string>

#include "piste/recordings/allan.h"

namespace piste {

/// `allan.csv`: a row for each τ; for each recorded axis the deviation with its interval (`_lci`, `_uci`), the fitted
/// model's deviation (`_model`) and the Haar wavelet variance of the scale 2τ (`_wv`). SI; empty if the recording is
/// too short for the scale.
std::string allan_csv(const AllanFindings& findings);

/// `allan.json`: recordings, processes with their intervals, density and bias instability, tested models, warnings, and
/// what the length does not determine. SI.
std::string allan_json(const AllanFindings& findings);

}  // namespace piste
