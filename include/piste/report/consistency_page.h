#pragma once
/// The page of an ensemble, which shows whether the sigmas are consistent with the errors.

#include <string>

#include "piste/consistency/consistency.h"

namespace piste {

/// A self-contained HTML file without network: the verdict, NEES over time with its band, RMSE with its
/// bound and the stated sigma, coverage, the tables of all phases, innovations, failed runs, how to read it, and
/// `scenario_text`. Times are seconds after the departure.
std::string consistency_html(const ConsistencyReport& report, const std::string& title, const std::string& version,
                             const std::string& scenario_text);

}  // namespace piste
