#pragma once
/// What an ensemble of runs says, as text. The same report gives the same bytes.

#include <string>

#include "piste/consistency/consistency.h"

namespace piste {

/// `consistency.json`: everything in the report, in the units of the block table; null where there is no number.
std::string consistency_json(const ConsistencyReport& report, const std::string& title);

/// One sentence: whether filter and smoother are consistent, and if not, what lies outside its band.
std::string consistency_verdict(const ConsistencyReport& report);

/// The verdict, then under way: NEES by group, RMSE over its bound of position, velocity and attitude, NIS by source.
/// A * stands behind what lies outside its band.
std::string consistency_text(const ConsistencyReport& report);

/// A Markdown table of ensembles, under way: its two head lines, and one line an ensemble. Aligned, to be read in a
/// terminal too.
std::string consistency_row_head();
std::string consistency_row(const ConsistencyReport& report, const std::string& title);

}  // namespace piste
