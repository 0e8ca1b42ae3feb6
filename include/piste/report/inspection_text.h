#pragma once
/// The text of an inspection for a terminal and for the page.

#include <optional>
#include <string>
#include <vector>

#include "piste/inspect/inspection.h"

namespace piste {

/// The facts about one log, or about two logs that were compared.
struct InspectionSheet {
  struct Fact {
    std::string name, text;
  };
  std::string title;
  std::vector<Fact> facts;
};

/// A sheet for every log in their order, then for every match.
std::vector<InspectionSheet> inspection_sheets(const Inspection& inspection);

/// All sheets, the configuration for a replay, and the suspicions, the worst first.
std::string inspection_text(const Inspection& inspection, const std::optional<std::string>& config);

}  // namespace piste
