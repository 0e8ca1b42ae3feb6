#pragma once
/// Tables 1 to 7 of a study on its page, next to the printed numbers of the article that the campaign names.

#include <string>

#include "piste/study/ranking.h"
#include "piste/study/study_findings.h"

namespace piste {

/// The body of a section: markup.
std::string study_page_tables(const Study& study, const Ranking& ranking);

}  // namespace piste
