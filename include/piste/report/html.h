#pragma once
/// The page that tells how a replay went.

#include <string>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

struct ReplayReport {
  std::string title;
  std::string version;                 ///< of the program
  std::string config_text;             ///< shown verbatim
  const Log* log = nullptr;            ///< @pre not null
  const Solution* filtered = nullptr;  ///< @pre not null
  const Solution* smoothed = nullptr;  ///< null = none was asked for
  std::vector<Interval> outages = {};  ///< shaded where GNSS was withheld
};

/// One HTML file that needs nothing beside it and no network: counts of everything, plan view, speed, height, attitude,
/// the other estimated blocks and all sigmas, innovations against their gates, and the config. Series are thinned
/// (thin.h); times are seconds after the first epoch.
std::string html_report(const ReplayReport& report);

}  // namespace piste
