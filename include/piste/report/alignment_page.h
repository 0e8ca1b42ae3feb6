#pragma once
/// The page that shows whether two IMUs were brought together.

#include <string>

#include "piste/report/alignment_figures.h"

namespace piste {

/// One HTML file that needs nothing beside it, no network and no JavaScript: the parameters with their sigmas, what the
/// motion did not determine, all figures, how to read them, and the configuration verbatim.
std::string alignment_html(const AlignmentPicture& picture);

}  // namespace piste
