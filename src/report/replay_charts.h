#pragma once
/// What the page of a replay draws.

#include <cstddef>
#include <vector>

#include "piste/report/html.h"
#include "report/page_data.h"

namespace piste::page {

/// The solution that the page shows first: smoothed, or else filtered.
inline const Solution& best_of(const ReplayReport& report) {
  return report.smoothed != nullptr ? *report.smoothed : *report.filtered;
}

/// Which rows of a solution the page has: those of a rate, and of more than `kKeptRows` every n-th.
std::vector<std::size_t> shown_rows(const Solution& solution, double rate);

/// Tables and charts of a replay. Solutions have all rows up to `kKeptRows`, and else every n-th of them.
Data replay_data(const ReplayReport& report);

}  // namespace piste::page
