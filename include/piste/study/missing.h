#pragma once
/// Lists what a study could not do, and why.

#include <string>
#include <vector>

#include "piste/study/study_findings.h"

namespace piste {

/// What is missing, and why: sentences for the page, the terminal and summary.json.
std::vector<std::string> missing(const Study& study);

}  // namespace piste
