#pragma once
/// The page of runs that are compared, and its text for a terminal.

#include <string>

#include "piste/descents/descents.h"

namespace piste {

/// A self-contained HTML file: where each run lost, sections, time gained and speed along the line, plan.
std::string descents_page(const DescentReport& report, const std::string& version);

/// A line for each section.
std::string descents_text(const DescentReport& report);

}  // namespace piste
