#pragma once
/// The page of a study.

#include <string>

#include "piste/study/study_findings.h"

namespace piste {

/// A self-contained HTML file without network or JavaScript: which estimates navigate best and how significantly, what
/// is missing and why, all tables and figures, comparisons of all methods with one another and with the truth,
/// coverage, every run, how to read it, and `config_text`. If the campaign names an article, its printed numbers are
/// shown next to their counterparts, and a section states what they imply. Biases and scales are corrections to add
/// (study_findings.h).
std::string study_html(const Study& study, const std::string& version, const std::string& config_text);

}  // namespace piste
