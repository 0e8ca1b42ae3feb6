#pragma once
/// The result of a study in sentences: which estimates navigate best, what the signals show, what is missing.

#include <string>

#include "piste/experiment/ranking.h"
#include "piste/experiment/study_findings.h"

namespace piste {

/// The body of a section: markup. If several methods tie, none is called the best.
std::string study_result(const Study& study, const Ranking& ranking);

}  // namespace piste
