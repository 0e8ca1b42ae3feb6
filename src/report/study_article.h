#pragma once
/// The section about the article that a campaign names: the implications of its printed numbers and of the campaign's
/// numbers.

#include <string>

#include "piste/study/study_findings.h"

namespace piste {

/// The body of a section: markup. @pre study.article
std::string article_section(const Study& study);

}  // namespace piste
