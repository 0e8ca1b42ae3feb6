#pragma once
/// What the printed numbers of the article that a campaign names imply, beside what those of the campaign do.

#include <string>

#include "piste/experiment/study_findings.h"

namespace piste {

/// The body of a section: markup. @pre study.article
std::string article_section(const Study& study);

}  // namespace piste
