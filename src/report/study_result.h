#pragma once
/// The result of a study in sentences: which estimates navigate best, what the signals show, what is missing.

#include <string>

#include "piste/study/ranking.h"
#include "piste/study/study_findings.h"

namespace piste {

/// The body of a section: markup. If several methods tie, none is called the best.
std::string study_result(const Study& study, const Ranking& ranking);

}  // namespace piste
