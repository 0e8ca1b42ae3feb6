#pragma once
/// The page that tells what a campaign taught.

#include <string>

#include "piste/experiment/study_findings.h"

namespace piste {

/// One HTML file that needs nothing beside it, no network and no JavaScript: which estimate navigates best and how
/// surely, what is missing and why, the article's tables with its printed numbers beside ours, all figures, every
/// method against every other and against the truth, coverage, what the article's numbers imply, every run, how to read
/// it, and `config_text` verbatim. Biases and scales are in the article's sign (study.h).
std::string study_html(const Study& study, const std::string& version, const std::string& config_text);

}  // namespace piste
