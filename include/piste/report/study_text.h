#pragma once
/// What a campaign taught, in words for a terminal.

#include <string>

#include "piste/experiment/study_findings.h"

namespace piste {

/// What ran, what is missing, which method wins, and the biases at rest.
std::string study_text(const Study& study);

}  // namespace piste
