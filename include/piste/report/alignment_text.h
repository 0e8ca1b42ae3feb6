#pragma once
/// What an alignment found, in words for a terminal.

#include <string>

#include "piste/condition/alignment.h"

namespace piste {

/// A few lines: offset, drift, boresight and lever arm with their sigmas, and what is to be known.
std::string alignment_text(const Alignment& alignment);

}  // namespace piste
