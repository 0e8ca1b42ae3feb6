#pragma once
/// The page of an alignment.

#include <string>

#include "piste/report/alignment_figures.h"

namespace piste {

/// A self-contained HTML file without network or JavaScript: the parameters with their sigmas, the parameters that the
/// motion did not determine, all figures, how to read them, and the text of the configuration.
std::string alignment_html(const AlignmentPicture& picture);

}  // namespace piste
