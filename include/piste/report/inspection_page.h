#pragma once
/// The page of an inspection.

#include <optional>
#include <string>

#include "piste/inspect/inspection.h"

namespace piste {

/// A self-contained HTML file without network: the suspicions, the worst first; facts and pictures of every log and
/// every match; the configuration for a replay.
std::string inspection_page(const Inspection& inspection, const std::optional<std::string>& config,
                            const std::string& version);

}  // namespace piste
