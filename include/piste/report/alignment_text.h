#pragma once
/// The text of an alignment for a terminal.

#include <string>

#include "piste/condition/alignment.h"

namespace piste {

/// A few lines: offset, drift, boresight and lever arm with their sigmas, and warnings.
std::string alignment_text(const Alignment& alignment);

}  // namespace piste
