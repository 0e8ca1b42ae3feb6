#pragma once
/// Guesses the quantities in the columns of a text log that no other reader knows.

#include <optional>
#include <string>
#include <string_view>

#include "piste/columns/log_guess.h"

namespace piste {

/// Guesses the mapping of `format: columns` from the header's names and units, or else from the values. Time is the
/// column that increases by even steps. The specific force is the three columns whose magnitude is mostly that of
/// gravity in some unit, and the gyroscopes are the three next to them. If the columns are merely x, y and z, the name
/// of the file separates gyroscopes from accelerometers. Nothing if the columns are not those of a log.
std::optional<LogGuess> guess_columns(const std::string& file, std::string_view content);

/// The names of the columns, for an error: the known ones with their quantities, and the others. Empty without a
/// header.
std::string known_columns(std::string_view content);

}  // namespace piste
