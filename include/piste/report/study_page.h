#pragma once
/// The page that tells what a campaign taught.

#include <string>

#include "piste/experiment/study_findings.h"

namespace piste {

/// One HTML file that needs nothing beside it, no network and no JavaScript: which estimates navigate best and how
/// surely, what is missing and why, all tables and figures, every method against every other and against the truth,
/// coverage, every run, how to read it, and `config_text` verbatim. Where the campaign names an article, its printed
/// numbers stand beside those of their counterparts, and a section says what they imply. Biases and scales are
/// corrections to add (study_findings.h).
std::string study_html(const Study& study, const std::string& version, const std::string& config_text);

}  // namespace piste
