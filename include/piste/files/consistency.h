#pragma once
/// The files of an ensemble: `consistency.json`, and a line of a Markdown table. Equal reports give equal bytes.

#include <string>

#include "piste/consistency/consistency.h"

namespace piste {

/// `consistency.json`: everything in the report, in the units of the block table. A missing number is null.
std::string consistency_json(const ConsistencyReport& report, const std::string& title);

/// A Markdown table of ensembles, for the time under way: its two header lines, and one line for an ensemble. The
/// columns are aligned, so that the table is legible in a terminal too.
std::string consistency_row_head();
std::string consistency_row(const ConsistencyReport& report, const std::string& title);

}  // namespace piste
