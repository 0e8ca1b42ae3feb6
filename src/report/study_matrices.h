#pragma once
/// Compares every method of a study with every other, in one table for each quantity and triad.

#include <string>

#include "piste/study/study_findings.h"

namespace piste {

/// The body of a section: markup.
std::string study_matrices(const Study& study);

}  // namespace piste
