#pragma once
/// What an ensemble of runs says, as files: `consistency.json`, and a line of a Markdown table. The same report gives
/// the same bytes.

#include <string>

#include "piste/consistency/consistency.h"

namespace piste {

/// `consistency.json`: everything in the report, in the units of the block table; null where there is no number.
std::string consistency_json(const ConsistencyReport& report, const std::string& title);

/// A Markdown table of ensembles, under way: its two head lines, and one line an ensemble. Aligned, to be read in a
/// terminal too.
std::string consistency_row_head();
std::string consistency_row(const ConsistencyReport& report, const std::string& title);

}  // namespace piste
