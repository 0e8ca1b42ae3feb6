#pragma once
/// What a study comes to, in sentences of markup: which estimates navigate best, what the signals say, what is missing.

#include <string>

#include "piste/experiment/ranking.h"
#include "piste/experiment/study_findings.h"

namespace piste {

/// The body of a section. Of methods that tie none is called the best.
std::string study_result(const Study& study, const Ranking& ranking);

}  // namespace piste
