#pragma once
/// The section about the article that a campaign names: what its printed numbers imply, and what those of the campaign
/// imply.

#include <string>

#include "piste/study/study_findings.h"

namespace piste {

/// The body of a section: markup. @pre study.article
std::string article_section(const Study& study);

}  // namespace piste
