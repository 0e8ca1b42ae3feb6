#pragma once
/// The page of a replay.

#include <string>
#include <vector>

#include "piste/consistency/verdict.h"
#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// The input of the page.
struct ReplayReport {
  std::string title;
  std::string version;                 ///< of the program
  std::string config_text;             ///< shown unchanged
  const Log* log = nullptr;            ///< @pre not null
  const Solution* filtered = nullptr;  ///< @pre not null
  const Solution* smoothed = nullptr;  ///< null if there is none
  const Verdict* verdict = nullptr;    ///< null if there is none
  std::vector<Interval> outages = {};  ///< shown as shaded
};

/// A self-contained HTML file without network: the verdict, all counts, plan view, speed, height, attitude, the other
/// estimated blocks and all sigmas, innovations with their gates, and the configuration. Series are thinned (thin.h).
/// Times are seconds after the first epoch.
std::string html_report(const ReplayReport& report);

}  // namespace piste
