#pragma once
/// The page that shows what an inspection found.

#include <optional>
#include <string>

#include "piste/inspect/inspection.h"

namespace piste {

/// One HTML file that needs nothing beside it and no network: what looks wrong, worst first; a sheet and pictures for
/// every log and every match; the ready configuration.
std::string inspection_page(const Inspection& inspection, const std::optional<std::string>& config,
                            const std::string& version);

}  // namespace piste
