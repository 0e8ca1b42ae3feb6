#pragma once
/// What the article's printed numbers imply, beside what those of a campaign do.

#include <string>

#include "piste/experiment/study_findings.h"

namespace piste {

/// The body of a section: markup.
std::string article_section(const Study& study);

}  // namespace piste
