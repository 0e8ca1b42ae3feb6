#pragma once
/// The page of an evaluation, and its text for a terminal.

#include <string>

#include "piste/evaluate/evaluation.h"

namespace piste {

/// A self-contained HTML file: statistics, tracks in plan, errors over time with the claimed sigmas, shares within
/// them.
std::string evaluation_page(const Evaluation& found, const std::string& version);

/// A few lines: what was compared, absolute and relative errors, whether the sigmas hold.
std::string evaluation_text(const Evaluation& found);

}  // namespace piste
