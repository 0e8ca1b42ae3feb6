#pragma once
/// The page that tells whether the sigmas are true.

#include <string>

#include "piste/consistency/consistency.h"

namespace piste {

/// One HTML file that needs nothing beside it, no network and no JavaScript: the verdict, NEES over time with its band,
/// RMSE against its bound and the claimed sigma, coverage, the tables of all phases, innovations, failed runs, how to
/// read it, and `scenario_text` verbatim. Times are seconds after the departure.
std::string consistency_html(const ConsistencyReport& report, const std::string& title, const std::string& version,
                             const std::string& scenario_text);

}  // namespace piste
