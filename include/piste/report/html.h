#pragma once
/// The page of a replay.

#include <optional>
#include <string>
#include <vector>

#include "piste/consistency/verdict.h"
#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// The input of the page.
struct ReplayReport {
  std::string title;
  std::string version;                     ///< of the program
  std::string config_text;                 ///< shown unchanged
  const Log* log = nullptr;                ///< @pre not null
  const Solution* filtered = nullptr;      ///< @pre not null
  const Solution* smoothed = nullptr;      ///< null if there is none
  const Verdict* verdict = nullptr;        ///< null if there is none
  std::vector<Interval> outages = {};      ///< shown as shaded
  const FilterOptions* options = nullptr;  ///< whose priors are shown next to the estimates; null: none are
  std::vector<std::string> warnings = {};  ///< as terminal and summary.json have them
  double rate = 0;               ///< of filtered.csv and smoothed.csv [Hz], whose rows are shown; 0: of the IMU
  std::optional<int> week = {};  ///< GPS week of the log's times; without it a page has seconds and no date
  double bias_rate = 10;         ///< of biases.csv
};

/// A self-contained HTML file without network: date and duration, whether the sigmas can be relied on, the accuracy
/// reached, warnings, plan, all counts, charts of everything that was estimated with its band, of all innovations and
/// their outcomes, and the configuration. Charts hold up to `kKeptRows` rows of a solution (replay/replay.h) and every
/// innovation; they draw the rows themselves where these are no more than two a pixel column, and else the least and
/// the largest value of each column.
std::string html_report(const ReplayReport& report);

}  // namespace piste
