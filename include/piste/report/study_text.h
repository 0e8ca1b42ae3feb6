#pragma once
/// The text of a study for a terminal.

#include <string>

#include "piste/study/study_findings.h"

namespace piste {

/// The runs, what is missing, which method wins, and the biases at rest.
std::string study_text(const Study& study);

}  // namespace piste
